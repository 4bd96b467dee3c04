
/* Columns, (samples, columns), through sections forward and backward. Values are so many apart in
   time and from column to column; `buffer` holds samples + 2 padding + 1 vectors. */
void filter_columns(ptrdiff_t samples, ptrdiff_t columns, const double *values, ptrdiff_t time,
                    ptrdiff_t column, ptrdiff_t sections, const double *taps,
                    const double *settled, ptrdiff_t padding, double *out, double *buffer)
{
    for (ptrdiff_t first = 0; first < columns; first += WIDE) {
        const ptrdiff_t left = columns - first, count = left < WIDE ? left : WIDE;
        double *const own = aligned(buffer) + WIDE * padding;
        for (ptrdiff_t k = 0; k < samples; ++k)
            for (ptrdiff_t c = 0; c < WIDE; ++c)
                own[k * WIDE + c] = c < count ? values[k * time + (first + c) * column] : 0.0;
        extended_without_phase((wide *)own, samples, padding, (int)sections, taps, settled);
        for (ptrdiff_t k = 0; k < samples; ++k)
            for (ptrdiff_t c = 0; c < count; ++c)
                out[k * columns + first + c] = own[k * WIDE + c];
    }
}
