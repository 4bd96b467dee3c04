/* Reversals and rests of lanes, and what the samples away from them tell of each parameter. */

/* Which samples, (samples, lanes), are within `reach` of a reversal or of a rest, where a lane is no
   faster than `rest` of its largest speed. */
void lanes_turns(ptrdiff_t samples, ptrdiff_t lanes, const double *velocity, double rest,
                 ptrdiff_t reach, unsigned char *near)
{
    enum { FAR, NEAR, TURN };
    for (ptrdiff_t first = 0; first < lanes; first += WIDE) {
        const ptrdiff_t left = lanes - first, count = left < WIDE ? left : WIDE;
        const double most = (double)reach;
        double slow[WIDE] = {0}, before[WIDE], since[WIDE];
        for (ptrdiff_t k = 0; k < samples; ++k)
            for (ptrdiff_t l = 0; l < count; ++l)
                slow[l] = fmax(slow[l], fabs(velocity[k * lanes + first + l]));
        for (ptrdiff_t l = 0; l < count; ++l) {
            slow[l] *= rest;
            since[l] = INFINITY;
        }
        for (ptrdiff_t k = 0; k < samples; ++k)
            for (ptrdiff_t l = 0; l < count; ++l) {
                const double v = velocity[k * lanes + first + l];
                const double direction = (double)((v > slow[l]) - (v < -slow[l]));
                const int turns = direction == 0.0 || (k && direction != before[l]);
                since[l] = turns ? 0.0 : since[l] + 1.0;
                before[l] = direction;
                near[k * lanes + first + l] = turns ? TURN : since[l] <= most ? NEAR : FAR;
            }
        for (ptrdiff_t l = 0; l < count; ++l)
            since[l] = INFINITY;
        for (ptrdiff_t k = samples - 1; k >= 0; --k)
            for (ptrdiff_t l = 0; l < count; ++l) {
                unsigned char *const at = near + k * lanes + first + l;
                since[l] = *at == TURN ? 0.0 : since[l] + 1.0;
                *at = *at != FAR || since[l] <= most;
            }
    }
}

/* Products of the regressor's columns, (parameters, parameters, lanes), over samples that are kept:
   those faster than a lane's `slow` speed, and those that are not near reversals. */
void lanes_information(ptrdiff_t samples, ptrdiff_t lanes, const double *q, const double *dq,
                       const double *ddq, const unsigned char *kept, const unsigned char *near,
                       const double *slow, double *moving, double *left)
{
    for (ptrdiff_t first = 0; first < lanes; first += WIDE) {
        const ptrdiff_t count = lanes - first;
        const wide slowest = load(slow + first, count);
        wide sums[2][PARAMETERS][PARAMETERS] = {0};
        for (ptrdiff_t k = 0; k < samples; ++k) {
            if (!kept[k])
                continue;
            const ptrdiff_t at = k * lanes + first;
            const wide motion[] = {load(q + at, count), load(dq + at, count),
                                   load(ddq + at, count)};
            wide rows[PARAMETERS], counts[2];
            for (int l = 0; l < WIDE; ++l) {
                const double v = motion[1][l];
                double row[PARAMETERS + 1];
                row_of(motion[0][l], v, motion[2][l], (double)((v > 0.0) - (v < 0.0)), row);
                for (int i = 0; i < PARAMETERS; ++i)
                    rows[i][l] = row[i];
                counts[0][l] = (double)(fabs(v) > slowest[l]);
                counts[1][l] = (double)!near[at + (l < count ? l : 0)];
            }
            for (int m = 0; m < 2; ++m)
                for (int i = 0; i < PARAMETERS; ++i)
                    for (int j = 0; j <= i; ++j)
                        sums[m][i][j] += counts[m] * rows[i] * rows[j];
        }
        for (int i = 0; i < PARAMETERS; ++i)
            for (int j = 0; j < PARAMETERS; ++j) {
                const ptrdiff_t place = (i * PARAMETERS + j) * lanes + first;
                store(moving + place, sums[0][i > j ? i : j][i > j ? j : i], count);
                store(left + place, sums[1][i > j ? i : j][i > j ? j : i], count);
            }
    }
}
