#if SIGNALS
/* What is held from a sample on: the force, or what a continuous law follows, and of each recorded
   signal its value and how it changes until the next sample. */
static inline void hold(double *held, double first, double rate, double error, double added,
                        const double *recorded)
{
    held[0] = first;
#if CONTINUOUS
    held[1] = rate;
    held[2] = error;
    held[3] = added;
#else
    (void)rate, (void)error, (void)added;
#endif
    for (int i = 0; i < 2 * SIGNALS; ++i)
        held[HELD - 2 * SIGNALS + i] = recorded[i];
}

#endif
#if RESPONSE
/* Of what the drive remembers, the force of the oldest command: at a sample of the one that acts
   first, at the next of the one that acts last. A command that begins to act in between, after its
   part of the sample, cuts it in two. */
enum { OLDEST = MEMORY - 1 - LAGGED };
#ifdef SPLIT
#define FIRST_TARGET(memory, next) (memory)[OLDEST]
enum { PARTS = 2 };
#else
#define FIRST_TARGET(memory, next) (next)[OLDEST]
enum { PARTS = 1 };
#endif

/* How long a step of a sample is, each part of which takes as many steps. */
static inline double step_of(ptrdiff_t i, double period, ptrdiff_t substeps)
{
#ifdef SPLIT
    const double until = SPLIT * period;
    return (i < substeps ? until : period - until) / (double)substeps;
#else
    (void)i;
    return period / (double)substeps;
#endif
}

#endif
/* One lane through one sample. */
struct lane {
    double q, dq;     /* at the sample, then at the next */
    struct mode mode; /* just after the sample, then just before the next */
    double direction, acceleration, force, control; /* just after the sample */
    double memory[AT_LEAST_1_MEMORY];
#if SIDES
    ptrdiff_t steps; /* that are left to it */
#endif
};

static double encoder(double q, double noise, double resolution)
{
    const double measured = q + noise;
    return resolution > 0.0 ? floor(measured / resolution + 0.5) * resolution - q : noise;
}

/* A sample that starts at rest, changes its mode or is taken in several steps. */
static int sample_with_events(struct lane *lane, double reference, double rate, double error,
#if SIGNALS
                              const double *recorded,
#endif
                              double added, const double *p, double period, ptrdiff_t substeps)
{
#if SIGNALS
    double memory[AT_LEAST_1_MEMORY], ignored[3], held[HELD];
#else
    double memory[AT_LEAST_1_MEMORY], ignored[3], held[4] = {0.0, rate, error, added};
#endif
#if STATES
    double ignored_states[STATES];
#endif
    struct mode *mode = &lane->mode;
    mode->direction = sign(lane->dq);
#if SIGNALS
    closed_loop_step(lane->q, lane->dq, lane->memory, reference, rate, error, added, recorded,
                     IN(mode), p, period, ignored, ignored + 1, memory, &lane->acceleration,
                     &lane->force, &lane->control, ignored + 2);
    hold(held, CONTINUOUS ? reference : lane->force, rate, error, added, recorded);
#else
    closed_loop_step(lane->q, lane->dq, lane->memory, reference, rate, error, added, IN(mode), p,
                     period, ignored, ignored + 1, memory, &lane->acceleration, &lane->force,
                     &lane->control, ignored + 2 STATES_(, ignored_states));
    held[0] = CONTINUOUS ? reference : lane->force;
#endif
#if LAGGED
    held[1] = FIRST_TARGET(lane->memory, memory);
#endif
    if (lane->dq == 0.0)
        choose_at_rest(lane->q, held, mode, p);
    held_acceleration(lane->q, lane->dq, held, IN(mode), p, &lane->acceleration, &lane->force);
    if (fabs(mode->direction) < 1.0)
        lane->acceleration = 0.0;
    lane->direction = mode->direction;
    for (int i = 0; i < MEMORY; ++i)
        lane->memory[i] = memory[i];
#if RESPONSE
    for (ptrdiff_t i = 0; i < PARTS * substeps; ++i) {
        if (i == substeps)
            held[LAGGED] = memory[OLDEST];
        if (i && lane->dq == 0.0)
            choose_at_rest(lane->q, held, mode, p);
        const int status = advance(&lane->q, &lane->dq, mode, held, p,
                                   step_of(i, period, substeps) SIDES_(, &lane->steps));
        if (status != DONE)
            return status;
    }
#else
    for (ptrdiff_t i = 0; i < substeps; ++i) {
        const int status = advance(&lane->q, &lane->dq, mode, held, p,
                                   period / (double)substeps SIDES_(, &lane->steps));
        if (status != DONE)
            return status;
        if (i + 1 < substeps && lane->dq == 0.0)
            choose_at_rest(lane->q, held, mode, p);
    }
#endif
    return DONE;
}

#ifdef __GNUC__
#define APART __attribute__((noinline)) /* would take registers from the common case */
#else
#define APART
#endif

/* Move on through the later substeps of a sample; `changes` says whether one changes the mode. */
#if RESPONSE
APART static struct moved later_substeps(struct moved end, const double *later, struct mode mode,
                                         const double *p, double period, double last_target,
                                         ptrdiff_t substeps, double *changes)
{
#else
APART static struct moved later_substeps(struct moved end, const double *later, struct mode mode,
                                         const double *p, double step, ptrdiff_t substeps,
                                         double *changes)
{
#endif
#if SIGNALS
    double held[HELD];
    for (int i = 0; i < HELD; ++i)
        held[i] = later[i];
#else
    double held[4] = {later[0], later[1], later[2], later[3]};
#endif
#if RESPONSE
    for (ptrdiff_t i = 1; i < PARTS * substeps; ++i) {
        const double q = end.q, dq = end.dq, step = step_of(i, period, substeps);
        pass(held, step_of(i - 1, period, substeps));
        if (i == substeps)
            held[LAGGED] = last_target;
#else
    for (ptrdiff_t i = 1; i < substeps; ++i) {
        const double q = end.q, dq = end.dq;
        pass(held, step);
#endif
#if STATES
        copy_states(mode.states, end.states);
#endif
        end = move(q, dq, held, &mode, p, step);
        *changes += events(q, dq, &end, held, &mode, p, step);
    }
    return end;
}

/* Where results go: one row a sample, `stride` values apart; what is null is not wanted. */
struct outputs {
    double *position, *velocity, *acceleration, *force, *control, *direction, *before;
    ptrdiff_t stride;
};

static void put(double *values, ptrdiff_t at, double value)
{
    if (values)
        values[at] = value;
}

/* What the drive remembers at the first sample: what is given, or that of an axis at rest. */
static inline void first_memory(double reference, double measured, const double *given,
#if SIGNALS
                                const double *recorded,
#endif
#if GAINS
                                const double *p,
#endif
                                double *memory)
{
    if (given)
        for (int i = 0; i < MEMORY; ++i)
            memory[i] = given[i];
    else
#if GAINS
#if SIGNALS
        start_of(reference, measured, recorded, p + PARAMETERS - GAINS, memory);
#else
        control_start(reference, measured, p + PARAMETERS - GAINS, memory);
#endif
#else
#if SIGNALS
        start_of(reference, measured, recorded, memory);
#else
        control_start(reference, measured, memory);
#endif
#endif
}

/* One simulation. Returns a status; `stopped` is the sample it speaks of. Noise is in the measured
   position, `injected` is added to the control; null for none. `remembered` is what the drive
   remembers at the first sample; null for that of an axis at rest. It ends, with nothing to show,
   once `stop` is set: its caller was interrupted. */
int simulate(ptrdiff_t samples, const double *reference, const double *noise, const double *injected,
#if SIGNALS
             const double *recorded,
#endif
             const double *parameters, double period, double start, double start_velocity,
             const double *remembered, double resolution, double allowed, ptrdiff_t substeps,
             double *position, double *velocity, double *acceleration, double *force,
             double *control, double *direction, double *before, ptrdiff_t *stopped,
             const volatile int *stop)
{
    struct lane lane = {.q = start SIDES_(, .steps = steps_in_all(samples))};
    struct mode mode = {0};
#if RESPONSE
    const double step = step_of(0, period, substeps);
#else
    const double step = period / (double)substeps;
#endif
    double p[PARAMETERS]; /* nothing else points here, so what depends on it alone leaves the loop */
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = parameters[j];
    double q = start, dq = start_velocity, memory[AT_LEAST_1_MEMORY] = {0.0}, end = 0.0;
    first_memory(reference[0], start + encoder(start, noise ? noise[0] : 0.0, resolution),
#if GAINS
#if SIGNALS
                 remembered, recorded, p, memory);
#else
                 remembered, p, memory);
#endif
#else
#if SIGNALS
                 remembered, recorded, memory);
#else
                 remembered, memory);
#endif
#endif
#if SIDES
#if MOVING
    double first[HELD];
    first_places(q, dq, &mode, p, recorded, first);
#endif
    choose_sides(q, dq, &mode, p, 0 MOVING_(, first));
#endif
#if STATES
    double first_limit;
    state_start(p, mode.states, &first_limit);
#endif
#ifdef FIRST_LIMIT
    mode.direction = sign(dq);
    choose_slipping(q, &mode, p);
#endif
    for (ptrdiff_t k = 0; k < samples; ++k) {
        double q1, dq1, ddq, last, tau, u, next[AT_LEAST_1_MEMORY];
        const double r = reference[k];
        const double rate = CONTINUOUS && k + 1 < samples ? (reference[k + 1] - r) / period : 0.0;
        const double error = encoder(q, noise ? noise[k] : 0.0, resolution);
        const double added = injected ? injected[k] : 0.0;
        *stopped = k;
        if (*stop)
            return DONE;
        if (!(fabs(q - r) <= allowed))
            return isfinite(q) ? OUT_OF_RANGE : NOT_FINITE;
        put(position, k, q);
        put(velocity, k, dq);
        put(before, k, end);
#if MOVING
        if (k)
            choose_shifted(q, dq, &mode, p, recorded + 2 * SIGNALS * (k - 1),
                           recorded + 2 * SIGNALS * k, period);
#endif
        mode.direction = sign(dq);
#if SIGNALS
        const double *const now = recorded + 2 * SIGNALS * k;
        double held[HELD];
        closed_loop_step(q, dq, memory, r, rate, error, added, now, IN(&mode), p, step, &q1, &dq1,
                         next, &ddq, &tau, &u, &last);
        hold(held, CONTINUOUS ? r : tau, rate, error, added, now);
#if LAGGED
        held[1] = FIRST_TARGET(memory, next);
#endif
        const struct moved moved = {q1, dq1, ddq, last};
#else
#if STATES
        struct moved moved;
        closed_loop_step(q, dq, memory, r, rate, error, added, IN(&mode), p, step, &q1, &dq1, next,
                         &ddq, &tau, &u, &last, moved.states);
        moved.q = q1;
        moved.dq = dq1;
        moved.first = ddq;
        moved.last = last;
#else
        closed_loop_step(q, dq, memory, r, rate, error, added, IN(&mode), p, step, &q1, &dq1, next,
                         &ddq, &tau, &u, &last);
        const struct moved moved = {q1, dq1, ddq, last};
#endif
#if LAGGED
        const double held[4] = {tau, FIRST_TARGET(memory, next)};
#else
        const double held[4] = {CONTINUOUS ? r : tau, rate, error, added};
#endif
#endif
        double changes = events(q, dq, &moved, held, &mode, p, step);
        end = mode.direction;
#if RESPONSE
        if (changes == 0.0 && PARTS * substeps > 1) {
            double more = 0.0;
            const struct moved end_of_sample = later_substeps(
                moved, held, mode, parameters, period, next[OLDEST], substeps, &more);
#else
        if (changes == 0.0 && substeps > 1) {
            double more = 0.0;
            const struct moved end_of_sample =
                later_substeps(moved, held, mode, parameters, step, substeps, &more);
#endif
            q1 = end_of_sample.q;
            dq1 = end_of_sample.dq;
#if STATES
            copy_states(moved.states, end_of_sample.states);
#endif
            changes = more;
        }
        if (!(changes == 0.0)) {
            lane.q = q;
            lane.dq = dq;
            lane.mode = mode;
            for (int i = 0; i < MEMORY; ++i)
                lane.memory[i] = memory[i];
            const int status =
#if SIGNALS
                sample_with_events(&lane, r, rate, error, now, added, parameters, period,
                                   substeps);
#else
                sample_with_events(&lane, r, rate, error, added, parameters, period, substeps);
#endif
            if (status != DONE)
                return status;
            q1 = lane.q;
            dq1 = lane.dq;
            ddq = lane.acceleration;
#if LAGGED
            tau = lane.force;
#endif
            mode = lane.mode;
            end = mode.direction;
            mode.direction = lane.direction;
        }
#if STATES
        else
            copy_states(mode.states, moved.states);
#endif
        put(acceleration, k, ddq);
        put(force, k, tau);
        put(control, k, u);
        put(direction, k, mode.direction);
        if (k == 0) /* nothing was held before */
            put(before, k, mode.direction);
        q = q1;
        dq = dq1;
        for (int i = 0; i < MEMORY; ++i)
            memory[i] = next[i];
    }
    return DONE;
}

