
/* Whether, and how finely, simulations start from rest. Of each lane, at its position and its own
   recorded signals and parameters: its accelerations pushed by a force of 1, left alone, and held by
   friction forward and backward; for either direction the rate of damping and stiffness, from how
   the acceleration changes over a probe. */
void from_rest_rows(ptrdiff_t lanes, const double *position, const double *signals,
                    const double *parameters, ptrdiff_t parameters_step, double *accelerations,
                    double *rates)
{
    static const double force[4] = {1.0, 0.0, 0.0, 0.0}, direction[4] = {0.0, 0.0, 1.0, -1.0};
    for (ptrdiff_t l = 0; l < lanes; ++l) {
        const double q = position[l], *const p = parameters + l * parameters_step;
#if SIGNALS
        const double *const now = signals + l * SIGNALS;
#else
        (void)signals;
#endif
        for (int i = 0; i < 4; ++i)
            direct_dynamics(q, 0.0, force[i], direction[i] WITH(now), p, accelerations + 4 * l + i);
#if RATES
        double held[HELD] = {CONTINUOUS ? q : 0.0}, way = PROBE, ignored;
#if SIGNALS
        for (int i = 0; i < SIGNALS; ++i)
            held[HELD - 2 * SIGNALS + 2 * i] = now[i];
#endif
#if WAVES
        double wave;
        wave_number(q WITH(now), p, &wave);
        way = PROBE / (1.0 + PROBE / PROBED * wave);
#endif
        for (int i = 0; i < 2; ++i) {
            const double s = i ? 1.0 : -1.0;
            double here, faster, further;
            held_acceleration(q, 0.0, held, s, p, &here, &ignored);
            held_acceleration(q, PROBE, held, s, p, &faster, &ignored);
            held_acceleration(q + way, 0.0, held, s, p, &further, &ignored);
            const double damping = fabs(faster - here) / PROBE;
            const double swinging = sqrt(fabs(further - here) / way);
            const double rate = damping > swinging ? damping : swinging;
            rates[2 * l + i] = isfinite(damping) && isfinite(swinging) ? rate : 0.0;
        }
#else
        (void)rates;
#endif
    }
}
