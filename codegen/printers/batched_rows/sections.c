/* Second-order sections along columns side by side, WIDE of them in vector registers.

   Time is the first axis of every array, columns or lanes the last; one that is not there repeats
   the first of its registers. */

enum { MOST_SECTIONS = 5 };
typedef double wide __attribute__((vector_size(8 * WIDE)));

/* Where registers may be loaded from, in memory that has WIDE values to spare. */
static inline double *aligned(double *memory)
{
    const uintptr_t size = sizeof(wide);
    return (double *)(((uintptr_t)memory + size - 1) / size * size);
}

static inline wide load(const double *values, ptrdiff_t count)
{
    wide found;
    if (count >= WIDE)
        memcpy(&found, values, sizeof found);
    else
        for (ptrdiff_t l = 0; l < WIDE; ++l)
            found[l] = values[l < count ? l : 0];
    return found;
}

static inline void store(double *values, wide found, ptrdiff_t count)
{
    if (count >= WIDE)
        memcpy(values, &found, sizeof found);
    else
        for (ptrdiff_t l = 0; l < count; ++l)
            values[l] = found[l];
}

/* Second-order sections one after the other along `count` values a `step` apart, from the state in
   which they have settled at the first; as SciPy's `sosfilt` has them, to the last bit. */
static inline void pass_sections(wide *values, ptrdiff_t count, ptrdiff_t step, int sections,
                                 const double *taps, const double *settled)
{
    wide state[MOST_SECTIONS][2];
    for (int s = 0; s < sections; ++s)
        for (int i = 0; i < 2; ++i)
            state[s][i] = settled[2 * s + i] * *values;
    for (ptrdiff_t k = 0; k < count; ++k, values += step) {
        wide x = *values;
        for (int s = 0; s < sections; ++s) {
            const double *b = taps + 6 * s, *a = b + 3;
            const wide y = b[0] * x + state[s][0];
            state[s][0] = (b[1] * x - a[1] * y) + state[s][1];
            state[s][1] = b[2] * x - a[2] * y;
            x = y;
        }
        *values = x;
    }
}

static void without_phase(wide *values, ptrdiff_t count, int sections, const double *taps,
                          const double *settled)
{
    switch (sections) { /* so that the compiler knows how many there are */
#define OF(n)                                                                                      \
    case n:                                                                                        \
        pass_sections(values, count, 1, n, taps, settled);                                         \
        pass_sections(values + count - 1, count, -1, n, taps, settled);                            \
        break;
        OF(1) OF(2) OF(3) OF(4) OF(5)
#undef OF
    }
}

/* Forward and backward with odd extensions: `count` values at the middle of `x` and room for the
   padding at both its ends. */
static void extended_without_phase(wide *x, ptrdiff_t count, ptrdiff_t padding, int sections,
                                   const double *taps, const double *settled)
{
    for (ptrdiff_t k = 1; k <= padding; ++k) {
        x[-k] = 2 * x[0] - x[k];
        x[count - 1 + k] = 2 * x[count - 1] - x[count - 1 - k];
    }
    without_phase(x - padding, count + 2 * padding, sections, taps, settled);
}
