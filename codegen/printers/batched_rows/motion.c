/* Rows of lanes: many records or simulated loops of one motion. */

enum { COLUMNS = PARAMETERS + KNOWN + 1 };

/* Positions through the low-pass, forward and backward with odd extensions, and their central
   differences; `buffer` holds samples + 2 padding + 1 vectors. */
void lanes_motion(ptrdiff_t samples, ptrdiff_t lanes, const double *position, ptrdiff_t sections,
                  const double *taps, const double *settled, ptrdiff_t padding, double period,
                  double *q, double *dq, double *ddq, double *buffer)
{
    for (ptrdiff_t first = 0; first < lanes; first += WIDE) {
        const ptrdiff_t count = lanes - first;
        wide *x = (wide *)aligned(buffer) + padding;
        for (ptrdiff_t k = 0; k < samples; ++k)
            x[k] = load(position + k * lanes + first, count);
        extended_without_phase(x, samples, padding, (int)sections, taps, settled);
        const double twice = 2 * period;
        wide before = (x[1] - x[0]) / period, now = before, after = now;
        for (ptrdiff_t k = 0; k < samples; ++k) {
            const ptrdiff_t at = k * lanes + first, left = samples - 1 - k;
            after = left > 1 ? (x[k + 2] - x[k]) / twice : left ? (x[k + 1] - x[k]) / period : now;
            store(q + at, x[k], count);
            store(dq + at, now, count);
            const wide change = k && left ? (after - before) / twice
                                          : (k ? now - before : after - now) / period;
            store(ddq + at, change, count);
            before = now;
            now = after;
        }
    }
}

