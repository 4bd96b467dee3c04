/* Values of one sample for all lanes of a block; those of the registers in use are stepped, so that
   few lanes cost little more than their share. */
struct block {
    double q[LANES], dq[LANES], memory[AT_LEAST_1_MEMORY][LANES], parameters[PARAMETERS][LANES];
    double reference[LANES], rate[LANES], error[LANES], added[LANES];
    double direction[LANES], end[LANES];
#if SIGNALS
    double recorded[2 * SIGNALS][LANES];
#endif
#if SIDES
    double sides[SIDES][LANES];
    ptrdiff_t steps[LANES];
#endif
#if STATES
    double states[STATES][LANES], states1[STATES][LANES];
#endif
    double q1[LANES], dq1[LANES], next[AT_LEAST_1_MEMORY][LANES];
    double ddq[LANES], tau[LANES], u[LANES], slow[LANES], allowed[LANES], now[LANES];
};

static inline struct mode mode_of(const struct block *b, int l, double direction)
{
    struct mode mode = {.direction = direction};
#if SIDES
    for (int j = 0; j < SIDES; ++j)
        mode.sides[j] = b->sides[j][l];
#else
    (void)b, (void)l;
#endif
#if STATES
    for (int j = 0; j < STATES; ++j)
        mode.states[j] = b->states[j][l];
#endif
    return mode;
}
#if STATES
static inline void copy_lane(double (*to)[LANES], int l, const double *states)
{
    for (int j = 0; j < STATES; ++j)
        to[j][l] = states[j];
}
#endif

static inline void keep_sides(struct block *b, int l, const struct mode *mode)
{
#if SIDES
    for (int j = 0; j < SIDES; ++j)
        b->sides[j][l] = mode->sides[j];
#else
    (void)b, (void)l, (void)mode;
#endif
}

#if SIGNALS
static inline void recorded_of(const struct block *b, int l, double *now)
{
    for (int j = 0; j < 2 * SIGNALS; ++j)
        now[j] = b->recorded[j][l];
}

#endif
/* The common case for all lanes at once; `slow` says which lanes it does not serve. */
static void step_block(struct block *b, int registers, double step, ptrdiff_t substeps)
{
    const int lanes = REGISTER * registers;
    for (int l = 0; l < lanes; ++l) {
        double p[PARAMETERS], memory[AT_LEAST_1_MEMORY] = {0.0}, next[AT_LEAST_1_MEMORY], tau, u;
        const double r = b->reference[l], rate = b->rate[l], error = b->error[l];
        const double added = b->added[l];
        const struct mode mode = mode_of(b, l, sign(b->dq[l]));
        struct moved moved;
        for (int j = 0; j < PARAMETERS; ++j)
            p[j] = b->parameters[j][l];
        for (int j = 0; j < MEMORY; ++j)
            memory[j] = b->memory[j][l];
#if SIGNALS
        double now[2 * SIGNALS];
        recorded_of(b, l, now);
        closed_loop_step(b->q[l], b->dq[l], memory, r, rate, error, added, now, IN(&mode), p, step,
                         &moved.q, &moved.dq, next, &moved.first, &tau, &u, &moved.last);
#else
        closed_loop_step(b->q[l], b->dq[l], memory, r, rate, error, added, IN(&mode), p, step,
                         &moved.q, &moved.dq, next, &moved.first, &tau, &u, &moved.last STATES_(,
                         moved.states));
#endif
#if STATES
        copy_lane(b->states1, l, moved.states);
#endif
        b->q1[l] = moved.q;
        b->dq1[l] = moved.dq;
        b->ddq[l] = moved.first;
        b->tau[l] = tau;
        b->u[l] = u;
        b->direction[l] = mode.direction;
        for (int j = 0; j < MEMORY; ++j)
            b->next[j][l] = next[j];
        const double away = fabs(b->q[l] - r) <= b->allowed[l] ? 0.0 : 1.0;
#if SIGNALS
        double held[HELD];
        hold(held, CONTINUOUS ? r : tau, rate, error, added, now);
#if LAGGED
        held[1] = FIRST_TARGET(memory, next);
#endif
#else
#if LAGGED
        const double held[4] = {tau, FIRST_TARGET(memory, next)};
#else
        const double held[4] = {CONTINUOUS ? r : tau, rate, error, added};
#endif
#endif
        b->slow[l] = events(b->q[l], b->dq[l], &moved, held, &mode, p, step) + away;
    }
#if RESPONSE
    (void)substeps;
}

/* What follows the first step of a sample, under a force that changes. */
static void respond_block(struct block *b, int registers, double period, ptrdiff_t substeps)
{
    const int lanes = REGISTER * registers;
    double elapsed = 0.0;
    for (int l = 0; l < lanes; ++l)
        b->now[l] = b->tau[l];
    for (ptrdiff_t i = 1; i < PARTS * substeps; ++i) {
        const double before = step_of(i - 1, period, substeps), step = step_of(i, period, substeps);
        for (int l = 0; l < lanes; ++l) {
            double p[PARAMETERS], held[HELD];
#if SIGNALS
            double now[2 * SIGNALS];
            recorded_of(b, l, now);
            for (int j = 0; j < 2 * SIGNALS; j += 2)
                now[j] += now[j + 1] * elapsed;
            hold(held, b->now[l], 0.0, 0.0, 0.0, now);
#else
            held[0] = b->now[l];
#endif
#if LAGGED
            held[1] = PARTS == 2 && i <= substeps ? b->memory[OLDEST][l] : b->next[OLDEST][l];
#endif
            pass(held, before);
            if (i == substeps)
                held[LAGGED] = b->next[OLDEST][l];
            b->now[l] = held[0];
            const struct mode mode = mode_of(b, l, b->direction[l]);
            for (int j = 0; j < PARAMETERS; ++j)
                p[j] = b->parameters[j][l];
            const struct moved moved = move(b->q1[l], b->dq1[l], held, &mode, p, step);
            b->slow[l] += events(b->q1[l], b->dq1[l], &moved, held, &mode, p, step);
            b->q1[l] = moved.q;
            b->dq1[l] = moved.dq;
        }
        elapsed += before;
    }
}
#else
    if (substeps > 1)
        for (int l = 0; l < lanes; ++l)
            b->now[l] = b->reference[l];
    for (ptrdiff_t i = 1; i < substeps; ++i)
        for (int l = 0; l < lanes; ++l) {
            double p[PARAMETERS];
#if SIGNALS
            double now[2 * SIGNALS], held[HELD];
            recorded_of(b, l, now);
            for (int j = 0; j < 2 * SIGNALS; j += 2)
                now[j] += now[j + 1] * step * (double)(i - 1);
            hold(held, CONTINUOUS ? b->now[l] : b->tau[l], b->rate[l], b->error[l], b->added[l],
                 now);
#else
            double held[4] = {CONTINUOUS ? b->now[l] : b->tau[l], b->rate[l], b->error[l],
                              b->added[l]};
#endif
#if STATES
            struct mode mode = mode_of(b, l, b->direction[l]);
            for (int j = 0; j < STATES; ++j)
                mode.states[j] = b->states1[j][l];
#else
            const struct mode mode = mode_of(b, l, b->direction[l]);
#endif
            pass(held, step);
            b->now[l] = held[0];
            for (int j = 0; j < PARAMETERS; ++j)
                p[j] = b->parameters[j][l];
            const struct moved moved = move(b->q1[l], b->dq1[l], held, &mode, p, step);
            b->slow[l] += events(b->q1[l], b->dq1[l], &moved, held, &mode, p, step);
            b->q1[l] = moved.q;
            b->dq1[l] = moved.dq;
#if STATES
            copy_lane(b->states1, l, moved.states);
#endif
        }
}
#endif

static int finish_lane(struct block *b, int l, double period, ptrdiff_t substeps)
{
    double p[PARAMETERS];
    struct lane lane = {.q = b->q[l], .dq = b->dq[l] SIDES_(, .steps = b->steps[l])};
    if (!(fabs(lane.q - b->reference[l]) <= b->allowed[l]))
        return isfinite(lane.q) ? OUT_OF_RANGE : NOT_FINITE;
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = b->parameters[j][l];
    for (int j = 0; j < MEMORY; ++j)
        lane.memory[j] = b->memory[j][l];
    lane.mode = mode_of(b, l, 0.0);
#if SIGNALS
    double now[2 * SIGNALS];
    recorded_of(b, l, now);
    const int status = sample_with_events(&lane, b->reference[l], b->rate[l], b->error[l], now,
                                          b->added[l], p, period, substeps);
#else
    const int status = sample_with_events(&lane, b->reference[l], b->rate[l], b->error[l],
                                          b->added[l], p, period, substeps);
#endif
    b->q1[l] = lane.q;
    b->dq1[l] = lane.dq;
    b->direction[l] = lane.direction;
    b->end[l] = lane.mode.direction;
    b->ddq[l] = lane.acceleration;
#if LAGGED
    b->tau[l] = lane.force;
#endif
    keep_sides(b, l, &lane.mode);
#if SIDES
    b->steps[l] = lane.steps;
#endif
#if STATES
    copy_lane(b->states1, l, lane.mode.states);
#endif
    return status;
}

/* The sides on which a lane starts. */
static void first_sides(struct block *b, int l MOVING_(, const double *now))
{
#if SIDES
    struct mode mode = {0};
    double p[PARAMETERS];
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = b->parameters[j][l];
#if MOVING
    double held[HELD];
    first_places(b->q[l], b->dq[l], &mode, p, now, held);
#endif
#ifdef FIRST_LIMIT
    mode = mode_of(b, l, sign(b->dq[l]));
#endif
    choose_sides(b->q[l], b->dq[l], &mode, p, 0 MOVING_(, held));
#ifdef FIRST_LIMIT
    choose_slipping(b->q[l], &mode, p);
#endif
    keep_sides(b, l, &mode);
#else
    (void)b, (void)l;
#endif
}
#if MOVING

/* The sides of a lane at a sample; `last` are the signals at the one before it. */
static void shifted_sides(struct block *b, int l, const double *last, double period)
{
    struct mode mode = mode_of(b, l, 0.0);
    double p[PARAMETERS], now[2 * SIGNALS];
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = b->parameters[j][l];
    recorded_of(b, l, now);
    choose_shifted(b->q[l], b->dq[l], &mode, p, last, now, period);
    keep_sides(b, l, &mode);
}
#endif

static void put_block(double *values, ptrdiff_t at, const double *own, ptrdiff_t count)
{
    if (values && count == LANES)
        for (int l = 0; l < LANES; ++l)
            values[at + l] = own[l];
    else if (values)
        for (ptrdiff_t l = 0; l < count; ++l)
            values[at + l] = own[l];
}

/* As many simulations side by side as the registers hold, of which `count` are wanted. */
static void simulate_block(int registers, ptrdiff_t samples, ptrdiff_t count,
                           const double *reference, ptrdiff_t reference_time,
                           ptrdiff_t reference_lane, const double *noise,
                           ptrdiff_t noise_time, ptrdiff_t noise_lane, const double *injected,
                           ptrdiff_t injected_time, ptrdiff_t injected_lane,
#if SIGNALS
                           const double *recorded, ptrdiff_t recorded_each,
                           ptrdiff_t recorded_time, ptrdiff_t recorded_lane,
#endif
                           const double *parameters, const double *start,
                           const double *start_velocity, const double *remembered,
                           const double *allowed, double period, double resolution,
                           ptrdiff_t substeps, struct outputs out, int *status,
                           ptrdiff_t *stopped, const volatile int *stop)
{
    const int lanes = REGISTER * registers;
    _Alignas(64) struct block b = {0}; /* a vector register never spans two cache lines */
    double dead[LANES] = {0.0};
    for (int l = 0; l < lanes; ++l) {
        const ptrdiff_t from = l < count ? l : 0;
        double memory[AT_LEAST_1_MEMORY] = {0.0};
        for (int j = 0; j < PARAMETERS; ++j)
            b.parameters[j][l] = parameters[from * PARAMETERS + j];
        b.q[l] = start[from];
        b.dq[l] = start_velocity[from];
        b.allowed[l] = allowed[from];
#if SIGNALS
        double now[2 * SIGNALS];
        for (int j = 0; j < 2 * SIGNALS; ++j)
            now[j] = recorded[j * recorded_each + from * recorded_lane];
#endif
        first_memory(reference[from * reference_lane],
                     b.q[l] + encoder(b.q[l], noise ? noise[from * noise_lane] : 0.0, resolution),
#if GAINS
#if SIGNALS
                     remembered ? remembered + from * MEMORY : NULL, now,
#else
                     remembered ? remembered + from * MEMORY : NULL,
#endif
                     parameters + from * PARAMETERS, memory);
#else
#if SIGNALS
                     remembered ? remembered + from * MEMORY : NULL, now, memory);
#else
                     remembered ? remembered + from * MEMORY : NULL, memory);
#endif
#endif
        for (int j = 0; j < MEMORY; ++j)
            b.memory[j][l] = memory[j];
#if STATES
        double begun[STATES], first_limit;
        state_start(parameters + from * PARAMETERS, begun, &first_limit);
        copy_lane(b.states, l, begun);
#endif
        first_sides(&b, l MOVING_(, now));
#if SIDES
        b.steps[l] = steps_in_all(samples);
#endif
        dead[l] = (double)(l >= count);
        if (l < count) {
            status[l] = DONE;
            stopped[l] = samples;
        }
    }
    /* A way out of the loop by itself would make it slower by a tenth. */
    for (ptrdiff_t k = 0; k < (*stop ? 0 : samples); ++k) {
        const ptrdiff_t at = k * out.stride;
        double any = 0.0;
        for (int l = 0; l < lanes; ++l) {
            const ptrdiff_t from = l < count ? l : 0;
            const double *r = reference + k * reference_time + from * reference_lane;
            b.reference[l] = *r;
            if (CONTINUOUS)
                b.rate[l] = k + 1 < samples ? (r[reference_time] - *r) / period : 0.0;
            if (noise || resolution > 0.0)
                b.error[l] = encoder(
                    b.q[l], noise ? noise[k * noise_time + from * noise_lane] : 0.0, resolution);
            if (injected)
                b.added[l] = injected[k * injected_time + from * injected_lane];
#if MOVING
            double last[2 * SIGNALS];
            recorded_of(&b, l, last);
#endif
#if SIGNALS
            for (int j = 0; j < 2 * SIGNALS; ++j)
                b.recorded[j][l] =
                    recorded[j * recorded_each + k * recorded_time + from * recorded_lane];
#endif
#if MOVING
            if (k)
                shifted_sides(&b, l, last, period);
#endif
        }
#if RESPONSE
        step_block(&b, registers, step_of(0, period, substeps), substeps);
        respond_block(&b, registers, period, substeps);
#else
        step_block(&b, registers, period / (double)substeps, substeps);
#endif
        put_block(out.before, at, k ? b.end : b.direction, count);
        for (int l = 0; l < lanes; ++l) {
            b.end[l] = b.direction[l];
            b.slow[l] = dead[l] > 0.0 ? 0.0 : b.slow[l];
            any += b.slow[l];
        }
        if (any > 0.0)
            for (int l = 0; l < count; ++l)
                if (b.slow[l] > 0.0) {
                    status[l] = finish_lane(&b, l, period, substeps);
                    if (status[l] != DONE) {
                        dead[l] = 1.0;
                        stopped[l] = k;
                        b.q1[l] = b.dq1[l] = NAN;
                    }
                }
        put_block(out.position, at, b.q, count);
        put_block(out.velocity, at, b.dq, count);
        put_block(out.acceleration, at, b.ddq, count);
        put_block(out.force, at, b.tau, count);
        put_block(out.control, at, b.u, count);
        put_block(out.direction, at, b.direction, count);
        if (k == 0)
            put_block(out.before, at, b.direction, count);
        for (int l = 0; l < lanes; ++l) {
            b.q[l] = b.q1[l];
            b.dq[l] = b.dq1[l];
#if STATES
            for (int j = 0; j < STATES; ++j)
                b.states[j][l] = b.states1[j][l];
#endif
            for (int j = 0; j < MEMORY; ++j)
                b.memory[j][l] = b.next[j][l];
        }
    }
}

/* Many simulations, `lanes` of them: parameters, start, what the drive remembers (null for that of
   an axis at rest) and status by lane; references, noise and what is added to the control with
   strides over time and lanes (0 where all lanes share one).
   Interrupted as one simulation is. */
void simulate_batch(ptrdiff_t samples, ptrdiff_t lanes, const double *reference,
                    ptrdiff_t reference_time, ptrdiff_t reference_lane, const double *noise,
                    ptrdiff_t noise_time, ptrdiff_t noise_lane, const double *injected,
#if SIGNALS
                    ptrdiff_t injected_time, ptrdiff_t injected_lane, const double *recorded,
                    ptrdiff_t recorded_each, ptrdiff_t recorded_time, ptrdiff_t recorded_lane,
                    const double *parameters,
#else
                    ptrdiff_t injected_time, ptrdiff_t injected_lane, const double *parameters,
#endif
                    const double *start, const double *start_velocity, const double *remembered,
                    const double *allowed, double period, double resolution, ptrdiff_t substeps,
                    double *position, double *velocity, double *acceleration, double *force,
                    double *control, double *direction, double *before, ptrdiff_t stride,
                    int *status, ptrdiff_t *stopped, const volatile int *stop)
{
    for (ptrdiff_t first = 0; first < lanes; first += LANES) {
        const ptrdiff_t left = lanes - first, count = left < LANES ? left : LANES;
        const int registers = (int)((count + REGISTER - 1) / REGISTER);
        const struct outputs out = {
            position ? position + first : NULL, velocity ? velocity + first : NULL,
            acceleration ? acceleration + first : NULL, force ? force + first : NULL,
            control ? control + first : NULL, direction ? direction + first : NULL,
            before ? before + first : NULL, stride};
        simulate_block(registers, samples, count, reference + first * reference_lane,
                       reference_time, reference_lane, noise ? noise + first * noise_lane : NULL,
                       noise_time, noise_lane,
                       injected ? injected + first * injected_lane : NULL, injected_time,
#if SIGNALS
                       injected_lane, recorded + first * recorded_lane, recorded_each,
                       recorded_time, recorded_lane, parameters + first * PARAMETERS, start + first,
#else
                       injected_lane, parameters + first * PARAMETERS, start + first,
#endif
                       start_velocity + first,
                       remembered ? remembered + first * MEMORY : NULL, allowed + first, period,
                       resolution, substeps, out, status + first, stopped + first, stop);
    }
}
