/* The closed loop over time: generic, around the functions of one axis printed above.

   The control law is evaluated once a sample; between samples the plant moves in one friction mode.
   Where the velocity reaches zero the crossing is located and the mode is chosen anew; at rest the
   model decides: with the accelerations a(+) and a(-) for both friction directions the axis sticks
   if and only if a(+) <= 0 <= a(-) (Filippov). One lane is one simulation. Lanes of a batch lie
   side by side, so that the common case of a sample vectorises; a lane that changes its mode is
   finished alone. */

#define JUST_LEFT 1e-6 /* of the time left in a sample */

enum { DONE, OUT_OF_RANGE, NOT_FINITE, CHATTER };
enum { MOST_EVENTS = 20, MOST_REFINEMENTS = 60, LANES = 32, AT_LEAST_1_MEMORY = MEMORY + !MEMORY };

/* Friction direction at zero velocity; strictly between -1 and 1 if the axis sticks. */
static double at_rest(double q, const double *held, const double *p)
{
    double forward, backward, tau;
    held_acceleration(q, 0.0, held, 1.0, p, &forward, &tau);
    held_acceleration(q, 0.0, held, -1.0, p, &backward, &tau);
    if (forward > 0.0)
        return 1.0;
    if (backward < 0.0)
        return -1.0;
    /* not a number if the force is not one */
    return backward == forward ? 0.0 : (backward + forward) / (backward - forward);
}

/* What is held, `span` seconds later. */
static void pass(double *held, double span)
{
#if CONTINUOUS
    held[0] += held[1] * span;
#else
    (void)held;
    (void)span;
#endif
}

/* Time at which a stuck axis leaves rest, at most `left`. */
static double breakaway(double q, const double *held, const double *p, double left)
{
#if CONTINUOUS
    double low = 0.0, high = left, later[HELD] = {held[0] + held[1] * left, held[1], held[2]};
    if (fabs(at_rest(q, later, p)) < 1.0)
        return left;
    for (int i = 0; i < MOST_REFINEMENTS; ++i) {
        const double middle = 0.5 * (low + high);
        later[0] = held[0] + held[1] * middle;
        if (fabs(at_rest(q, later, p)) < 1.0)
            low = middle;
        else
            high = middle;
    }
    return high;
#else
    (void)q, (void)held, (void)p;
    return left;
#endif
}

/* Time at which the velocity reaches zero; by `high` it has changed its sign. */
static double crossing(double q, double dq, const double *held, double direction, const double *p,
                       double high)
{
    double q1, dq1, first, last;
    double low = 0.0, t = high * JUST_LEFT;
    if (dq == 0.0) { /* just left rest: it crosses zero again only after a while */
        plant_step(q, dq, held, direction, p, t, &q1, &dq1, &first, &last);
        if (dq1 * direction <= 0.0)
            return t;
        low = t;
    }
    t = 0.5 * (low + high);
    for (int i = 0; i < MOST_REFINEMENTS; ++i) {
        plant_step(q, dq, held, direction, p, t, &q1, &dq1, &first, &last);
        if (dq1 == 0.0)
            break;
        if (dq1 * direction > 0.0)
            low = t;
        else
            high = t;
        double next = t - dq1 / last;
        if (!(next > low && next < high))
            next = 0.5 * (low + high);
        if (next == t)
            break;
        t = next;
    }
    return t;
}

/* Whether the velocity of a step that ends in its direction has dipped below zero on the way. */
static int dips(double q, double dq, const double *held, double direction, const double *p,
                double first, double last, double *span)
{
    double q1, dq1, ignored, too;
    if (dq == 0.0 || !(first * direction < 0.0 && last * direction > 0.0))
        return 0; /* from rest it leaves in its direction, whatever rounding says */
    const double lowest = *span * first / (first - last);
    plant_step(q, dq, held, direction, p, lowest, &q1, &dq1, &ignored, &too);
    if (dq1 * direction >= 0.0)
        return 0;
    *span = lowest;
    return 1;
}

/* Move for `left` seconds through every change of the friction direction. */
static int advance(double *q, double *dq, double *direction, double *held, const double *p,
                   double left)
{
    for (int event = 0; event < MOST_EVENTS; ++event) {
        double q1, dq1, first, last, span = left;
        if (fabs(*direction) < 1.0) {
            span = breakaway(*q, held, p, left);
            pass(held, span);
            left -= span;
            if (left <= 0.0) {
#if CONTINUOUS
                *direction = at_rest(*q, held, p);
#endif
                return DONE;
            }
            *direction = at_rest(*q, held, p);
            continue;
        }
        plant_step(*q, *dq, held, *direction, p, left, &q1, &dq1, &first, &last);
        if (!isfinite(q1) || !isfinite(dq1))
            return NOT_FINITE;
        if (dq1 * *direction >= 0.0 && !dips(*q, *dq, held, *direction, p, first, last, &span)) {
            *q = q1;
            *dq = dq1;
            pass(held, left);
            return DONE;
        }
        span = crossing(*q, *dq, held, *direction, p, span);
        plant_step(*q, *dq, held, *direction, p, span, &q1, &dq1, &first, &last);
        *q = q1;
        *dq = 0.0;
        pass(held, span);
        left -= span;
        *direction = at_rest(*q, held, p);
        if (left <= 0.0)
            return DONE;
    }
    return CHATTER;
}

/* 1 if a step in a mode has reached zero velocity, or may have crossed it twice. */
static inline double turns(double dq1, double first, double last, double mode)
{
    const double reaches = dq1 * mode > 0.0 ? 0.0 : 1.0;
    const double bends = first * mode < 0.0 ? (last * mode > 0.0 ? 1.0 : 0.0) : 0.0;
    return reaches + bends;
}

/* One lane through one sample. */
struct lane {
    double q, dq;                     /* at the sample, then at the next */
    double direction, end;            /* friction direction just after the sample, and before the next */
    double acceleration, force, control;
    double memory[AT_LEAST_1_MEMORY];
};

static double encoder(double q, double noise, double resolution)
{
    const double measured = q + noise;
    return resolution > 0.0 ? floor(measured / resolution + 0.5) * resolution - q : noise;
}

/* A sample that starts at rest, changes its mode or is taken in several steps. */
static int sample_with_events(struct lane *lane, double reference, double rate, double error,
                              const double *p, double period, ptrdiff_t substeps)
{
    double memory[AT_LEAST_1_MEMORY], ignored[3], held[3] = {0.0, rate, error};
    closed_loop_step(lane->q, lane->dq, lane->memory, reference, rate, error, sign(lane->dq), p,
                     period, ignored, ignored + 1, memory, &lane->acceleration, &lane->force,
                     &lane->control, ignored + 2);
    held[0] = CONTINUOUS ? reference : lane->force;
    lane->direction = lane->dq == 0.0 ? at_rest(lane->q, held, p) : sign(lane->dq);
    held_acceleration(lane->q, lane->dq, held, lane->direction, p, &lane->acceleration,
                      &lane->force);
    if (fabs(lane->direction) < 1.0)
        lane->acceleration = 0.0;
    lane->end = lane->direction;
    for (int i = 0; i < MEMORY; ++i)
        lane->memory[i] = memory[i];
    for (ptrdiff_t i = 0; i < substeps; ++i) {
        const int status =
            advance(&lane->q, &lane->dq, &lane->end, held, p, period / (double)substeps);
        if (status != DONE)
            return status;
        if (i + 1 < substeps && lane->dq == 0.0)
            lane->end = at_rest(lane->q, held, p);
    }
    return DONE;
}

/* Move on through the later substeps of a sample; whether one of them changes the mode. */
static inline double later_substeps(double *q, double *dq, double force, double reference,
                                    double rate, double error, double mode, const double *p,
                                    double step, ptrdiff_t substeps)
{
    double held[3] = {CONTINUOUS ? reference : force, rate, error}, changes = 0.0;
    for (ptrdiff_t i = 1; i < substeps; ++i) {
        double q1, dq1, first, last;
        pass(held, step);
        plant_step(*q, *dq, held, mode, p, step, &q1, &dq1, &first, &last);
        changes += turns(dq1, first, last, mode);
        *q = q1;
        *dq = dq1;
    }
    return changes;
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

/* One simulation. Returns a status; `stopped` is the sample it speaks of. It ends, with nothing to
   show, once `stop` is set: its caller was interrupted. */
int simulate(ptrdiff_t samples, const double *reference, const double *noise, const double *parameters,
             double period, double start, double resolution, double allowed, ptrdiff_t substeps,
             double *position, double *velocity, double *acceleration, double *force,
             double *control, double *direction, double *before, ptrdiff_t *stopped,
             const volatile int *stop)
{
    struct lane lane = {.q = start};
    const double step = period / (double)substeps;
    double p[PARAMETERS]; /* nothing else points here, so what depends on it alone leaves the loop */
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = parameters[j];
    double q = start, dq = 0.0, memory[AT_LEAST_1_MEMORY] = {0.0}, end = 0.0;
    control_start(reference[0], start + encoder(start, noise ? noise[0] : 0.0, resolution), memory);
    for (ptrdiff_t k = 0; k < samples; ++k) {
        double q1, dq1, ddq, tau, u, last, next[AT_LEAST_1_MEMORY], mode = sign(dq);
        const double r = reference[k];
        const double rate = CONTINUOUS && k + 1 < samples ? (reference[k + 1] - r) / period : 0.0;
        const double error = encoder(q, noise ? noise[k] : 0.0, resolution);
        *stopped = k;
        if (*stop)
            return DONE;
        if (!(fabs(q - r) <= allowed))
            return isfinite(q) ? OUT_OF_RANGE : NOT_FINITE;
        put(position, k, q);
        put(velocity, k, dq);
        put(before, k, end);
        closed_loop_step(q, dq, memory, r, rate, error, mode, p, step, &q1, &dq1, next, &ddq, &tau,
                         &u, &last);
        end = mode;
        double changes = turns(dq1, ddq, last, mode);
        if (changes == 0.0 && substeps > 1)
            changes = later_substeps(&q1, &dq1, tau, r, rate, error, mode, parameters, step,
                                     substeps);
        if (!(changes == 0.0)) {
            lane.q = q;
            lane.dq = dq;
            for (int i = 0; i < MEMORY; ++i)
                lane.memory[i] = memory[i];
            const int status =
                sample_with_events(&lane, r, rate, error, parameters, period, substeps);
            if (status != DONE)
                return status;
            q1 = lane.q;
            dq1 = lane.dq;
            mode = lane.direction;
            end = lane.end;
            ddq = lane.acceleration;
        }
        put(acceleration, k, ddq);
        put(force, k, tau);
        put(control, k, u);
        put(direction, k, mode);
        if (k == 0) /* nothing was held before */
            put(before, k, mode);
        q = q1;
        dq = dq1;
        for (int i = 0; i < MEMORY; ++i)
            memory[i] = next[i];
    }
    return DONE;
}

/* Values of one sample for all lanes of a block. */
struct block {
    double q[LANES], dq[LANES], memory[AT_LEAST_1_MEMORY][LANES], parameters[PARAMETERS][LANES];
    double reference[LANES], rate[LANES], error[LANES], mode[LANES], end[LANES];
    double q1[LANES], dq1[LANES], next[AT_LEAST_1_MEMORY][LANES];
    double ddq[LANES], tau[LANES], u[LANES], slow[LANES], allowed[LANES], now[LANES];
};

/* The common case for all lanes at once; `slow` says which lanes it does not serve. */
static void step_block(struct block *b, double step, ptrdiff_t substeps)
{
    for (int l = 0; l < LANES; ++l) {
        double p[PARAMETERS], memory[AT_LEAST_1_MEMORY] = {0.0}, next[AT_LEAST_1_MEMORY];
        double q1, dq1, ddq, tau, u, last;
        const double mode = sign(b->dq[l]);
        for (int j = 0; j < PARAMETERS; ++j)
            p[j] = b->parameters[j][l];
        for (int j = 0; j < MEMORY; ++j)
            memory[j] = b->memory[j][l];
        closed_loop_step(b->q[l], b->dq[l], memory, b->reference[l], b->rate[l], b->error[l], mode,
                         p, step, &q1, &dq1, next, &ddq, &tau, &u, &last);
        b->q1[l] = q1;
        b->dq1[l] = dq1;
        b->ddq[l] = ddq;
        b->tau[l] = tau;
        b->u[l] = u;
        b->mode[l] = mode;
        for (int j = 0; j < MEMORY; ++j)
            b->next[j][l] = next[j];
        const double away = fabs(b->q[l] - b->reference[l]) <= b->allowed[l] ? 0.0 : 1.0;
        b->slow[l] = turns(dq1, ddq, last, mode) + away;
        b->now[l] = b->reference[l];
    }
    for (ptrdiff_t i = 1; i < substeps; ++i)
        for (int l = 0; l < LANES; ++l) {
            double p[PARAMETERS], q1, dq1, first, last;
            double held[3] = {CONTINUOUS ? b->now[l] : b->tau[l], b->rate[l], b->error[l]};
            pass(held, step);
            b->now[l] = held[0];
            for (int j = 0; j < PARAMETERS; ++j)
                p[j] = b->parameters[j][l];
            plant_step(b->q1[l], b->dq1[l], held, b->mode[l], p, step, &q1, &dq1, &first, &last);
            b->q1[l] = q1;
            b->dq1[l] = dq1;
            b->slow[l] += turns(dq1, first, last, b->mode[l]);
        }
}

static int finish_lane(struct block *b, int l, double period, ptrdiff_t substeps)
{
    double p[PARAMETERS];
    struct lane lane = {.q = b->q[l], .dq = b->dq[l]};
    if (!(fabs(lane.q - b->reference[l]) <= b->allowed[l]))
        return isfinite(lane.q) ? OUT_OF_RANGE : NOT_FINITE;
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = b->parameters[j][l];
    for (int j = 0; j < MEMORY; ++j)
        lane.memory[j] = b->memory[j][l];
    const int status = sample_with_events(&lane, b->reference[l], b->rate[l], b->error[l], p, period,
                                          substeps);
    b->q1[l] = lane.q;
    b->dq1[l] = lane.dq;
    b->mode[l] = lane.direction;
    b->end[l] = lane.end;
    b->ddq[l] = lane.acceleration;
    return status;
}

static void put_block(double *values, ptrdiff_t at, const double *lanes, ptrdiff_t count)
{
    if (values && count == LANES)
        for (int l = 0; l < LANES; ++l)
            values[at + l] = lanes[l];
    else if (values)
        for (ptrdiff_t l = 0; l < count; ++l)
            values[at + l] = lanes[l];
}

/* LANES simulations side by side, of which `count` are wanted. */
static void simulate_block(ptrdiff_t samples, ptrdiff_t count, const double *reference,
                           ptrdiff_t reference_time, ptrdiff_t reference_lane, const double *noise,
                           ptrdiff_t noise_time, ptrdiff_t noise_lane, const double *parameters,
                           const double *start, const double *allowed, double period,
                           double resolution, ptrdiff_t substeps, struct outputs out, int *status,
                           ptrdiff_t *stopped, const volatile int *stop)
{
    struct block b = {0};
    double dead[LANES] = {0.0};
    for (int l = 0; l < LANES; ++l) {
        const ptrdiff_t from = l < count ? l : 0;
        double memory[AT_LEAST_1_MEMORY] = {0.0};
        for (int j = 0; j < PARAMETERS; ++j)
            b.parameters[j][l] = parameters[from * PARAMETERS + j];
        b.q[l] = start[from];
        b.allowed[l] = allowed[from];
        control_start(reference[from * reference_lane],
                      b.q[l] + encoder(b.q[l], noise ? noise[from * noise_lane] : 0.0, resolution),
                      memory);
        for (int j = 0; j < MEMORY; ++j)
            b.memory[j][l] = memory[j];
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
        for (int l = 0; l < LANES; ++l) {
            const ptrdiff_t from = l < count ? l : 0;
            const double *r = reference + k * reference_time + from * reference_lane;
            b.reference[l] = *r;
            if (CONTINUOUS)
                b.rate[l] = k + 1 < samples ? (r[reference_time] - *r) / period : 0.0;
            if (noise || resolution > 0.0)
                b.error[l] = encoder(
                    b.q[l], noise ? noise[k * noise_time + from * noise_lane] : 0.0, resolution);
        }
        step_block(&b, period / (double)substeps, substeps);
        put_block(out.before, at, k ? b.end : b.mode, count);
        for (int l = 0; l < LANES; ++l) {
            b.end[l] = b.mode[l];
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
        put_block(out.direction, at, b.mode, count);
        if (k == 0)
            put_block(out.before, at, b.mode, count);
        for (int l = 0; l < LANES; ++l) {
            b.q[l] = b.q1[l];
            b.dq[l] = b.dq1[l];
            for (int j = 0; j < MEMORY; ++j)
                b.memory[j][l] = b.next[j][l];
        }
    }
}

/* Many simulations, `lanes` of them: parameters, start and status by lane; references and noise with
   strides over time and lanes (0 where all lanes share one). Interrupted as one simulation is. */
void simulate_batch(ptrdiff_t samples, ptrdiff_t lanes, const double *reference,
                    ptrdiff_t reference_time, ptrdiff_t reference_lane, const double *noise,
                    ptrdiff_t noise_time, ptrdiff_t noise_lane, const double *parameters,
                    const double *start, const double *allowed, double period, double resolution,
                    ptrdiff_t substeps, double *position, double *velocity, double *acceleration,
                    double *force, double *control, double *direction, double *before,
                    ptrdiff_t stride, int *status, ptrdiff_t *stopped, const volatile int *stop)
{
    for (ptrdiff_t first = 0; first < lanes; first += LANES) {
        const ptrdiff_t left = lanes - first;
        const struct outputs out = {
            position ? position + first : NULL, velocity ? velocity + first : NULL,
            acceleration ? acceleration + first : NULL, force ? force + first : NULL,
            control ? control + first : NULL, direction ? direction + first : NULL,
            before ? before + first : NULL, stride};
        simulate_block(samples, left < LANES ? left : LANES, reference + first * reference_lane,
                       reference_time, reference_lane, noise ? noise + first * noise_lane : NULL,
                       noise_time, noise_lane, parameters + first * PARAMETERS, start + first,
                       allowed + first, period, resolution, substeps, out, status + first,
                       stopped + first, stop);
    }
}
