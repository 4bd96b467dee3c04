/* The closed loop over time: generic, around the functions of one axis printed above.

   The control law is evaluated once a sample; between samples the plant moves in one mode: a friction
   direction, and a side of each place where the acceleration has a kink or jumps over the position.
   Where the velocity reaches zero, or the axis such a place, the event is located and the mode is
   chosen anew; at rest the model decides: with the accelerations a(+) and a(-) for both friction
   directions the axis sticks if and only if a(+) <= 0 <= a(-) (Filippov). An axis with such places
   takes as many steps as its rates ask for where it is. One lane is one simulation. Lanes of a batch
   lie side by side, so that the common case of a sample vectorises; a lane that changes its mode is
   finished alone. */

#define JUST_LEFT 1e-6        /* of the time left in a sample */
#define STUCK (1.0 - 0x1p-53) /* the largest direction at rest */

enum { DONE, OUT_OF_RANGE, NOT_FINITE, CHATTER, UNRESOLVED };
enum { MOST_EVENTS = SIDES ? 4096 : 20, MOST_REFINEMENTS = 60, LANES = 32 };
enum { AT_LEAST_1_MEMORY = MEMORY + !MEMORY };

struct mode {
    double direction; /* strictly between -1 and 1 if the axis sticks */
#if SIDES
    double sides[SIDES]; /* -1 or 1; 0 if the axis rests in the place itself */
#endif
};

#if SIDES
#define IN(mode) (mode)->direction, (mode)->sides
#else
#define IN(mode) (mode)->direction
#endif

/* A motion after a step, and its acceleration at both ends. */
struct moved {
    double q, dq, first, last;
};

static inline struct moved move(double q, double dq, const double *held, const struct mode *mode,
                                const double *p, double step)
{
    struct moved end;
    plant_step(q, dq, held, IN(mode), p, step, &end.q, &end.dq, &end.first, &end.last);
    return end;
}

#if SIDES
#define AT_START (RESOLVED * (1.0 + 1e-6)) /* so that rounding does not decide for round numbers */
#define CAUGHT (1.0 / 1024.0)                 /* of a step */
enum { MOST_STEPS = 16384 };

/* What decides the sides, and how it changes with the position and the velocity. */
struct switches {
    double value[SIDES], by_position[SIDES], by_velocity[SIDES];
};

static inline struct switches switches_at(double q, double dq, const struct mode *mode,
                                          const double *p)
{
    struct switches s;
    switching(q, dq, mode->sides, p, s.value, s.by_position, s.by_velocity);
    return s;
}

/* The sides at a state; one may depend on those before it. */
static void choose_sides(double q, double dq, struct mode *mode, const double *p, int first)
{
    for (int i = first; i < SIDES; ++i) {
        const double value = switches_at(q, dq, mode, p).value[i];
        mode->sides[i] = value == 0.0 ? mode->sides[i] : sign(value);
    }
}

/* The sides of an axis that leaves rest: where it rested in a place, the one ahead of it. */
static void choose_ahead(double q, struct mode *mode, const double *p)
{
    const struct switches s = switches_at(q, 0.0, mode, p);
    for (int i = 0; i < SIDES; ++i)
        if (mode->sides[i] == 0.0)
            mode->sides[i] = s.by_position[i] * mode->direction < 0.0 ? -1.0 : 1.0;
}

static inline double rate_at(double q, double dq, const double *held, const struct mode *mode,
                             const double *p)
{
    double rate;
    plant_rate(q, dq, held, IN(mode), p, &rate);
    return rate;
}

/* Whether one step from a state to another changes a side, or may have changed it twice. */
static inline double strays(double q, double dq, const struct moved *end, const struct mode *mode,
                            const double *p)
{
    const struct switches s = switches_at(q, dq, mode, p);
    const struct switches t = switches_at(end->q, end->dq, mode, p);
    double changes = 0.0;
    for (int i = 0; i < SIDES; ++i) {
        const double side = mode->sides[i];
        const double first = (s.by_position[i] * dq + s.by_velocity[i] * end->first) * side;
        const double last = (t.by_position[i] * end->dq + t.by_velocity[i] * end->last) * side;
        changes += t.value[i] * side >= 0.0 ? 0.0 : 1.0;
        changes += first < 0.0 ? (last > 0.0 ? 1.0 : 0.0) : 0.0;
    }
    return changes;
}

/* Whether one step from a state to another is too long for the rates at its ends. */
static inline double hurries(double q, double dq, const struct moved *end, const double *held,
                             const struct mode *mode, const double *p, double step)
{
    const double first = rate_at(q, dq, held, mode, p) * step <= AT_START ? 0.0 : 1.0;
    return first + (rate_at(end->q, end->dq, held, mode, p) * step <= 2.0 * RESOLVED ? 0.0 : 1.0);
}
#endif

/* The accelerations with which an axis at rest would leave, forward and backward. */
struct leaving {
    double forward, backward;
};

static struct leaving leaving_at(double q, const double *held, const struct mode *mode,
                                 const double *p)
{
    struct leaving a;
    struct mode ahead = *mode, behind = *mode;
    double tau;
    ahead.direction = 1.0;
    behind.direction = -1.0;
#if SIDES
    choose_ahead(q, &ahead, p);
    choose_ahead(q, &behind, p);
#endif
    held_acceleration(q, 0.0, held, IN(&ahead), p, &a.forward, &tau);
    held_acceleration(q, 0.0, held, IN(&behind), p, &a.backward, &tau);
    return a;
}

/* Friction direction at zero velocity; strictly between -1 and 1 if the axis sticks. */
static double direction_of(struct leaving a)
{
    if (a.forward > 0.0)
        return 1.0;
    if (a.backward < 0.0)
        return -1.0;
    /* not a number if the force is not one */
    const double share = a.backward == a.forward
                             ? 0.0
                             : (a.backward + a.forward) / (a.backward - a.forward);
    return share >= 1.0 ? STUCK : share <= -1.0 ? -STUCK : share;
}

static double at_rest(double q, const double *held, const struct mode *mode, const double *p)
{
    return direction_of(leaving_at(q, held, mode, p));
}

/* The mode of an axis at rest that may leave. */
static void choose_at_rest(double q, const double *held, struct mode *mode, const double *p)
{
    mode->direction = at_rest(q, held, mode, p);
#if SIDES
    if (fabs(mode->direction) >= 1.0)
        choose_ahead(q, mode, p);
#endif
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
static double breakaway(double q, const double *held, const struct mode *mode, const double *p,
                        double left)
{
#if CONTINUOUS
    double low = 0.0, high = left;
    double later[HELD] = {held[0] + held[1] * left, held[1], held[2], held[3]};
    if (fabs(at_rest(q, later, mode, p)) < 1.0)
        return left;
    for (int i = 0; i < MOST_REFINEMENTS; ++i) {
        const double middle = 0.5 * (low + high);
        later[0] = held[0] + held[1] * middle;
        if (fabs(at_rest(q, later, mode, p)) < 1.0)
            low = middle;
        else
            high = middle;
    }
    return high;
#else
    (void)q, (void)held, (void)mode, (void)p;
    return left;
#endif
}

/* Time at which the velocity reaches zero; by `high` it has changed its sign. */
static double crossing(double q, double dq, const double *held, const struct mode *mode,
                       const double *p, double high)
{
    const double direction = mode->direction;
    double low = 0.0, t = high * JUST_LEFT;
    if (dq == 0.0) { /* just left rest: it crosses zero again only after a while */
        if (move(q, dq, held, mode, p, t).dq * direction <= 0.0)
            return t;
        low = t;
    }
    t = 0.5 * (low + high);
    for (int i = 0; i < MOST_REFINEMENTS; ++i) {
        const struct moved end = move(q, dq, held, mode, p, t);
        if (end.dq == 0.0)
            break;
        if (end.dq * direction > 0.0)
            low = t;
        else
            high = t;
        double next = t - end.dq / end.last;
        if (!(next > low && next < high))
            next = 0.5 * (low + high);
        if (next == t)
            break;
        t = next;
    }
    return t;
}

/* Whether the velocity of a step that ends in its direction has dipped below zero on the way. */
static int dips(double q, double dq, const double *held, const struct mode *mode, const double *p,
                const struct moved *end, double *span)
{
    const double direction = mode->direction;
    if (dq == 0.0 || !(end->first * direction < 0.0 && end->last * direction > 0.0))
        return 0; /* from rest it leaves in its direction, whatever rounding says */
    const double lowest = *span * end->first / (end->first - end->last);
    if (move(q, dq, held, mode, p, lowest).dq * direction >= 0.0)
        return 0;
    *span = lowest;
    return 1;
}

/* Whether the velocity reaches zero in a step, which then ends there. */
static int reverses(double q, double dq, const double *held, const struct mode *mode,
                    const double *p, double *span, struct moved *end)
{
    if (end->dq * mode->direction >= 0.0 && !dips(q, dq, held, mode, p, end, span))
        return 0;
    *span = crossing(q, dq, held, mode, p, *span);
    *end = move(q, dq, held, mode, p, *span);
    end->dq = 0.0;
    return 1;
}

#if SIDES
/* Time at which a side changes; by `high` it has changed. */
static double change_of(int i, double q, double dq, const double *held, const struct mode *mode,
                        const double *p, double high)
{
    double low = 0.0, t = 0.5 * high;
    for (int n = 0; n < MOST_REFINEMENTS; ++n) {
        const struct moved end = move(q, dq, held, mode, p, t);
        const struct switches s = switches_at(end.q, end.dq, mode, p);
        if (s.value[i] == 0.0)
            break;
        if (s.value[i] * mode->sides[i] > 0.0)
            low = t;
        else
            high = t;
        double next =
            t - s.value[i] / (s.by_position[i] * end.dq + s.by_velocity[i] * end.last);
        if (!(next > low && next < high))
            next = 0.5 * (low + high);
        if (next == t)
            break;
        t = next;
    }
    return t;
}

/* The first side that changes in a step, which then ends there; -1 if none does. */
static int passes(double q, double dq, const double *held, const struct mode *mode, const double *p,
                  double *span, struct moved *end)
{
    const struct switches s = switches_at(q, dq, mode, p);
    struct switches t = switches_at(end->q, end->dq, mode, p);
    int passed = -1;
    for (int i = 0; i < SIDES; ++i) {
        const double side = mode->sides[i];
        double high = *span;
        if (t.value[i] * side >= 0.0) { /* it may have been beyond in between */
            const double first = (s.by_position[i] * dq + s.by_velocity[i] * end->first) * side;
            const double last = (t.by_position[i] * end->dq + t.by_velocity[i] * end->last) * side;
            if (!(first < 0.0 && last > 0.0))
                continue;
            high *= first / (first - last);
            const struct moved lowest = move(q, dq, held, mode, p, high);
            if (switches_at(lowest.q, lowest.dq, mode, p).value[i] * side >= 0.0)
                continue;
        }
        *span = change_of(i, q, dq, held, mode, p, high);
        *end = move(q, dq, held, mode, p, *span);
        t = switches_at(end->q, end->dq, mode, p);
        passed = i;
    }
    return passed;
}

/* Whether an axis that passes a place is held there: its acceleration points to it on both sides,
   so that it would come back, and pass again, ever sooner. If friction would hold it on each side
   too, it is left to come to rest by itself. */
static int is_caught(int i, double q, double dq, const double *held, struct mode mode,
                     const double *p, double whole)
{
    mode.sides[i] = 0.0;
    const struct leaving a = leaving_at(q, held, &mode, p);
    const double slower = a.backward < -a.forward ? a.backward : -a.forward;
    if (!(2.0 * fabs(dq) < CAUGHT * whole * slower))
        return 0;
    mode.sides[i] = 1.0;
    if (fabs(at_rest(q, held, &mode, p)) >= 1.0)
        return 1;
    mode.sides[i] = -1.0;
    return fabs(at_rest(q, held, &mode, p)) >= 1.0;
}

/* The mode of an axis in a place where a side changes. */
static void choose_beyond(int i, double q, double *dq, const double *held, struct mode *mode,
                          const double *p, double whole)
{
    mode->sides[i] = -mode->sides[i];
    choose_sides(q, *dq, mode, p, i + 1);
    if (is_caught(i, q, *dq, held, *mode, p, whole)) {
        mode->sides[i] = 0.0;
        *dq = 0.0;
    }
    if (*dq == 0.0)
        choose_at_rest(q, held, mode, p);
}

/* A step as long as the rates at its ends allow, at most `span`. */
static int attempt(double q, double dq, const double *held, const struct mode *mode, const double *p,
                   double whole, double *span, struct moved *end)
{
    const double rate = rate_at(q, dq, held, mode, p), steps = ceil(*span * rate / AT_START);
    if (rate * whole > AT_START * MOST_STEPS)
        return UNRESOLVED;
    if (steps > 1.0)
        *span /= steps;
    for (;;) {
        *end = move(q, dq, held, mode, p, *span);
        if (rate_at(end->q, end->dq, held, mode, p) * *span <= 2.0 * RESOLVED)
            return DONE;
        if (2.0 * MOST_STEPS * *span < whole)
            return isfinite(end->q) && isfinite(end->dq) ? UNRESOLVED : NOT_FINITE;
        *span *= 0.5;
    }
}
#endif

/* Move for `whole` seconds through every change of the mode. */
static int advance(double *q, double *dq, struct mode *mode, double *held, const double *p,
                   double whole)
{
    double left = whole;
    for (int event = 0; event < MOST_EVENTS;) {
        const double before = *q, direction = mode->direction;
        const int from_rest = *dq == 0.0;
        double span = left;
        if (fabs(direction) < 1.0) {
            span = breakaway(*q, held, mode, p, left);
            pass(held, span);
            left -= span;
            if (left <= 0.0) {
#if CONTINUOUS
                mode->direction = at_rest(*q, held, mode, p);
#endif
                return DONE;
            }
            choose_at_rest(*q, held, mode, p);
            ++event;
            continue;
        }
#if SIDES
        struct moved end;
        const int status = attempt(*q, *dq, held, mode, p, whole, &span, &end);
        if (status != DONE)
            return status;
#else
        struct moved end = move(*q, *dq, held, mode, p, left);
#endif
        if (!isfinite(end.q) || !isfinite(end.dq))
            return NOT_FINITE;
        const int reversed = reverses(*q, *dq, held, mode, p, &span, &end);
#if SIDES
        const int passed = passes(*q, *dq, held, mode, p, &span, &end);
#else
        const int passed = -1;
#endif
        *q = end.q;
        *dq = end.dq;
        pass(held, span);
        left -= span;
        if (passed >= 0) {
#if SIDES
            choose_beyond(passed, *q, dq, held, mode, p, whole);
#endif
        } else if (reversed) {
            choose_at_rest(*q, held, mode, p);
            if (from_rest && *q == before && mode->direction == direction) {
                /* It turned back before its position changed: what moves it is rounding. */
                mode->direction *= STUCK;
                pass(held, left);
                return DONE;
            }
        }
        event += reversed || passed >= 0;
        if (left <= 0.0)
            return DONE;
    }
    return CHATTER;
}

/* 1 if a step in a mode has reached zero velocity, or may have crossed it twice. */
static inline double turns(const struct moved *end, double direction)
{
    const double reaches = end->dq * direction > 0.0 ? 0.0 : 1.0;
    const double bends =
        end->first * direction < 0.0 ? (end->last * direction > 0.0 ? 1.0 : 0.0) : 0.0;
    return reaches + bends;
}

/* 1 or more if a step has changed its mode, or may have; or if it was too long. */
static inline double events(double q, double dq, const struct moved *end, const double *held,
                            const struct mode *mode, const double *p, double step)
{
    double found = turns(end, mode->direction);
#if SIDES
    found += strays(q, dq, end, mode, p) + hurries(q, dq, end, held, mode, p, step);
#else
    (void)q, (void)dq, (void)held, (void)p, (void)step;
#endif
    return found;
}

/* One lane through one sample. */
struct lane {
    double q, dq;     /* at the sample, then at the next */
    struct mode mode; /* just after the sample, then just before the next */
    double direction, acceleration, force, control; /* just after the sample */
    double memory[AT_LEAST_1_MEMORY];
};

static double encoder(double q, double noise, double resolution)
{
    const double measured = q + noise;
    return resolution > 0.0 ? floor(measured / resolution + 0.5) * resolution - q : noise;
}

/* A sample that starts at rest, changes its mode or is taken in several steps. */
static int sample_with_events(struct lane *lane, double reference, double rate, double error,
                              double added, const double *p, double period, ptrdiff_t substeps)
{
    double memory[AT_LEAST_1_MEMORY], ignored[3], held[4] = {0.0, rate, error, added};
    struct mode *mode = &lane->mode;
    mode->direction = sign(lane->dq);
    closed_loop_step(lane->q, lane->dq, lane->memory, reference, rate, error, added, IN(mode), p,
                     period, ignored, ignored + 1, memory, &lane->acceleration, &lane->force,
                     &lane->control, ignored + 2);
    held[0] = CONTINUOUS ? reference : lane->force;
    if (lane->dq == 0.0)
        choose_at_rest(lane->q, held, mode, p);
    held_acceleration(lane->q, lane->dq, held, IN(mode), p, &lane->acceleration, &lane->force);
    if (fabs(mode->direction) < 1.0)
        lane->acceleration = 0.0;
    lane->direction = mode->direction;
    for (int i = 0; i < MEMORY; ++i)
        lane->memory[i] = memory[i];
    for (ptrdiff_t i = 0; i < substeps; ++i) {
        const int status = advance(&lane->q, &lane->dq, mode, held, p, period / (double)substeps);
        if (status != DONE)
            return status;
        if (i + 1 < substeps && lane->dq == 0.0)
            choose_at_rest(lane->q, held, mode, p);
    }
    return DONE;
}

#ifdef __GNUC__
#define APART __attribute__((noinline)) /* would take registers from the common case */
#else
#define APART
#endif

/* Move on through the later substeps of a sample; `changes` says whether one changes the mode. */
APART static struct moved later_substeps(struct moved end, const double *later, struct mode mode,
                                         const double *p, double step, ptrdiff_t substeps,
                                         double *changes)
{
    double held[4] = {later[0], later[1], later[2], later[3]};
    for (ptrdiff_t i = 1; i < substeps; ++i) {
        const double q = end.q, dq = end.dq;
        pass(held, step);
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
static void first_memory(double reference, double measured, const double *given, double *memory)
{
    if (given)
        for (int i = 0; i < MEMORY; ++i)
            memory[i] = given[i];
    else
        control_start(reference, measured, memory);
}

/* One simulation. Returns a status; `stopped` is the sample it speaks of. Noise is in the measured
   position, `injected` is added to the control; null for none. `remembered` is what the drive
   remembers at the first sample; null for that of an axis at rest. It ends, with nothing to show,
   once `stop` is set: its caller was interrupted. */
int simulate(ptrdiff_t samples, const double *reference, const double *noise, const double *injected,
             const double *parameters, double period, double start, double start_velocity,
             const double *remembered, double resolution, double allowed, ptrdiff_t substeps,
             double *position, double *velocity, double *acceleration, double *force,
             double *control, double *direction, double *before, ptrdiff_t *stopped,
             const volatile int *stop)
{
    struct lane lane = {.q = start};
    struct mode mode = {0};
    const double step = period / (double)substeps;
    double p[PARAMETERS]; /* nothing else points here, so what depends on it alone leaves the loop */
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = parameters[j];
    double q = start, dq = start_velocity, memory[AT_LEAST_1_MEMORY] = {0.0}, end = 0.0;
    first_memory(reference[0], start + encoder(start, noise ? noise[0] : 0.0, resolution),
                 remembered, memory);
#if SIDES
    choose_sides(q, dq, &mode, p, 0);
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
        mode.direction = sign(dq);
        closed_loop_step(q, dq, memory, r, rate, error, added, IN(&mode), p, step, &q1, &dq1, next,
                         &ddq, &tau, &u, &last);
        const struct moved moved = {q1, dq1, ddq, last};
        const double held[4] = {CONTINUOUS ? r : tau, rate, error, added};
        double changes = events(q, dq, &moved, held, &mode, p, step);
        end = mode.direction;
        if (changes == 0.0 && substeps > 1) {
            double more = 0.0;
            const struct moved end_of_sample =
                later_substeps(moved, held, mode, parameters, step, substeps, &more);
            q1 = end_of_sample.q;
            dq1 = end_of_sample.dq;
            changes = more;
        }
        if (!(changes == 0.0)) {
            lane.q = q;
            lane.dq = dq;
            lane.mode = mode;
            for (int i = 0; i < MEMORY; ++i)
                lane.memory[i] = memory[i];
            const int status =
                sample_with_events(&lane, r, rate, error, added, parameters, period, substeps);
            if (status != DONE)
                return status;
            q1 = lane.q;
            dq1 = lane.dq;
            ddq = lane.acceleration;
            mode = lane.mode;
            end = mode.direction;
            mode.direction = lane.direction;
        }
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

/* Values of one sample for all lanes of a block. */
struct block {
    double q[LANES], dq[LANES], memory[AT_LEAST_1_MEMORY][LANES], parameters[PARAMETERS][LANES];
    double reference[LANES], rate[LANES], error[LANES], added[LANES];
    double direction[LANES], end[LANES];
#if SIDES
    double sides[SIDES][LANES];
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
    return mode;
}

static inline void keep_sides(struct block *b, int l, const struct mode *mode)
{
#if SIDES
    for (int j = 0; j < SIDES; ++j)
        b->sides[j][l] = mode->sides[j];
#else
    (void)b, (void)l, (void)mode;
#endif
}

/* The common case for all lanes at once; `slow` says which lanes it does not serve. */
static void step_block(struct block *b, double step, ptrdiff_t substeps)
{
    for (int l = 0; l < LANES; ++l) {
        double p[PARAMETERS], memory[AT_LEAST_1_MEMORY] = {0.0}, next[AT_LEAST_1_MEMORY], tau, u;
        const double r = b->reference[l], rate = b->rate[l], error = b->error[l];
        const double added = b->added[l];
        const struct mode mode = mode_of(b, l, sign(b->dq[l]));
        struct moved moved;
        for (int j = 0; j < PARAMETERS; ++j)
            p[j] = b->parameters[j][l];
        for (int j = 0; j < MEMORY; ++j)
            memory[j] = b->memory[j][l];
        closed_loop_step(b->q[l], b->dq[l], memory, r, rate, error, added, IN(&mode), p, step,
                         &moved.q, &moved.dq, next, &moved.first, &tau, &u, &moved.last);
        b->q1[l] = moved.q;
        b->dq1[l] = moved.dq;
        b->ddq[l] = moved.first;
        b->tau[l] = tau;
        b->u[l] = u;
        b->direction[l] = mode.direction;
        for (int j = 0; j < MEMORY; ++j)
            b->next[j][l] = next[j];
        const double away = fabs(b->q[l] - r) <= b->allowed[l] ? 0.0 : 1.0;
        const double held[4] = {CONTINUOUS ? r : tau, rate, error, added};
        b->slow[l] = events(b->q[l], b->dq[l], &moved, held, &mode, p, step) + away;
    }
    if (substeps > 1)
        for (int l = 0; l < LANES; ++l)
            b->now[l] = b->reference[l];
    for (ptrdiff_t i = 1; i < substeps; ++i)
        for (int l = 0; l < LANES; ++l) {
            double p[PARAMETERS];
            double held[4] = {CONTINUOUS ? b->now[l] : b->tau[l], b->rate[l], b->error[l],
                              b->added[l]};
            const struct mode mode = mode_of(b, l, b->direction[l]);
            pass(held, step);
            b->now[l] = held[0];
            for (int j = 0; j < PARAMETERS; ++j)
                p[j] = b->parameters[j][l];
            const struct moved moved = move(b->q1[l], b->dq1[l], held, &mode, p, step);
            b->slow[l] += events(b->q1[l], b->dq1[l], &moved, held, &mode, p, step);
            b->q1[l] = moved.q;
            b->dq1[l] = moved.dq;
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
    lane.mode = mode_of(b, l, 0.0);
    const int status = sample_with_events(&lane, b->reference[l], b->rate[l], b->error[l],
                                          b->added[l], p, period, substeps);
    b->q1[l] = lane.q;
    b->dq1[l] = lane.dq;
    b->direction[l] = lane.direction;
    b->end[l] = lane.mode.direction;
    b->ddq[l] = lane.acceleration;
    keep_sides(b, l, &lane.mode);
    return status;
}

/* The sides on which a lane starts. */
static void first_sides(struct block *b, int l)
{
#if SIDES
    struct mode mode = {0};
    double p[PARAMETERS];
    for (int j = 0; j < PARAMETERS; ++j)
        p[j] = b->parameters[j][l];
    choose_sides(b->q[l], b->dq[l], &mode, p, 0);
    keep_sides(b, l, &mode);
#else
    (void)b, (void)l;
#endif
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
                           ptrdiff_t noise_time, ptrdiff_t noise_lane, const double *injected,
                           ptrdiff_t injected_time, ptrdiff_t injected_lane,
                           const double *parameters, const double *start,
                           const double *start_velocity, const double *remembered,
                           const double *allowed, double period, double resolution,
                           ptrdiff_t substeps, struct outputs out, int *status,
                           ptrdiff_t *stopped, const volatile int *stop)
{
    _Alignas(64) struct block b = {0}; /* a vector register never spans two cache lines */
    double dead[LANES] = {0.0};
    for (int l = 0; l < LANES; ++l) {
        const ptrdiff_t from = l < count ? l : 0;
        double memory[AT_LEAST_1_MEMORY] = {0.0};
        for (int j = 0; j < PARAMETERS; ++j)
            b.parameters[j][l] = parameters[from * PARAMETERS + j];
        b.q[l] = start[from];
        b.dq[l] = start_velocity[from];
        b.allowed[l] = allowed[from];
        first_memory(reference[from * reference_lane],
                     b.q[l] + encoder(b.q[l], noise ? noise[from * noise_lane] : 0.0, resolution),
                     remembered ? remembered + from * MEMORY : NULL, memory);
        for (int j = 0; j < MEMORY; ++j)
            b.memory[j][l] = memory[j];
        first_sides(&b, l);
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
            if (injected)
                b.added[l] = injected[k * injected_time + from * injected_lane];
        }
        step_block(&b, period / (double)substeps, substeps);
        put_block(out.before, at, k ? b.end : b.direction, count);
        for (int l = 0; l < LANES; ++l) {
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
        for (int l = 0; l < LANES; ++l) {
            b.q[l] = b.q1[l];
            b.dq[l] = b.dq1[l];
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
                    ptrdiff_t injected_time, ptrdiff_t injected_lane, const double *parameters,
                    const double *start, const double *start_velocity, const double *remembered,
                    const double *allowed, double period, double resolution, ptrdiff_t substeps,
                    double *position, double *velocity, double *acceleration, double *force,
                    double *control, double *direction, double *before, ptrdiff_t stride,
                    int *status, ptrdiff_t *stopped, const volatile int *stop)
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
                       noise_time, noise_lane,
                       injected ? injected + first * injected_lane : NULL, injected_time,
                       injected_lane, parameters + first * PARAMETERS, start + first,
                       start_velocity + first,
                       remembered ? remembered + first * MEMORY : NULL, allowed + first, period,
                       resolution, substeps, out, status + first, stopped + first, stop);
    }
}
