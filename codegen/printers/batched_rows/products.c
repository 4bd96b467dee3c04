/* Sums over rows of products of columns, (p, q, lanes), of (rows, p, lanes) and (rows, q, lanes)
   whose rows are so many values apart. */
void lanes_products(ptrdiff_t rows, ptrdiff_t lanes, ptrdiff_t p, ptrdiff_t q, const double *one,
                    ptrdiff_t one_row, const double *other, ptrdiff_t other_row, double *out)
{
    for (ptrdiff_t i = 0; i < p; ++i)
        for (ptrdiff_t j = 0; j < q; ++j)
            for (ptrdiff_t first = 0; first < lanes; first += WIDE) {
                const ptrdiff_t count = lanes - first;
                const double *a = one + i * lanes + first, *b = other + j * lanes + first;
                wide sums[2] = {{0}, {0}};
                for (ptrdiff_t k = 0; k < rows; ++k, a += one_row, b += other_row)
                    sums[k % 2] += load(a, count) * load(b, count);
                store(out + (i * q + j) * lanes + first, sums[0] + sums[1], count);
            }
}
