/* What is held, `span` seconds later. */
static void pass(double *held, double span)
{
#if LAGGED
    double until;
    drive_response(held[0], held[1], span, held, &until);
#endif
#if CONTINUOUS
    held[0] += held[1] * span;
#else
    (void)held;
    (void)span;
#endif
#if SIGNALS
    for (int i = HELD - 2 * SIGNALS; i < HELD; i += 2)
        held[i] += held[i + 1] * span;
#endif
}

#if LAGGED
static int sticks_after(double q, const double *held, const struct mode *mode, const double *p,
                        double span)
{
    double later[HELD];
    for (int i = 0; i < HELD; ++i)
        later[i] = held[i];
    pass(later, span);
    return fabs(at_rest(q, later, mode, p)) < 1.0;
}

#endif
/* Time at which a stuck axis leaves rest, at most `left`. */
static double breakaway(double q, const double *held, const struct mode *mode, const double *p,
                        double left)
{
#if LAGGED
    double low = 0.0, high = left;
    if (sticks_after(q, held, mode, p, left))
        return left;
    for (int i = 0; i < MOST_REFINEMENTS; ++i) {
        const double middle = 0.5 * (low + high);
        if (sticks_after(q, held, mode, p, middle))
            low = middle;
        else
            high = middle;
    }
    return high;
#else
#if SIGNALS
    double low = 0.0, high = left, later[HELD];
    for (int i = 0; i < HELD; ++i)
        later[i] = held[i];
    pass(later, left);
    if (fabs(at_rest(q, later, mode, p)) < 1.0)
        return left;
    for (int n = 0; n < MOST_REFINEMENTS; ++n) {
        const double middle = 0.5 * (low + high);
        for (int i = 0; i < HELD; ++i)
            later[i] = held[i];
        pass(later, middle);
        if (fabs(at_rest(q, later, mode, p)) < 1.0)
            low = middle;
        else
            high = middle;
    }
    return high;
#else
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
#endif
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
#if STATES
        const struct mode after = mode_after(mode, &end);
        const struct switches s = switches_at(end.q, end.dq, &after, p);
#else
        const struct switches s = switches_at(end.q, end.dq, mode, p MOVING_(, held, t));
#endif
        if (s.value[i] == 0.0)
            break;
        if (s.value[i] * mode->sides[i] > 0.0)
            low = t;
        else
            high = t;
        double next =
            t - s.value[i] / (s.by_position[i] * end.dq + s.by_velocity[i] * end.last MOVING_( +
                              s.by_time[i]));
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
    const struct switches s = switches_at(q, dq, mode, p MOVING_(, held, 0.0));
#if STATES
    struct mode after = mode_after(mode, end);
    struct switches t = switches_at(end->q, end->dq, &after, p);
#else
    struct switches t = switches_at(end->q, end->dq, mode, p MOVING_(, held, *span));
#endif
    int passed = -1;
    for (int i = 0; i < SIDES; ++i) {
        const double side = mode->sides[i];
        double high = *span;
        if (t.value[i] * side >= 0.0) { /* it may have been beyond in between */
            const double first = (s.by_position[i] * dq + s.by_velocity[i] * end->first MOVING_( +
                              s.by_time[i])) * side;
            const double last = (t.by_position[i] * end->dq + t.by_velocity[i] * end->last MOVING_( +
                              t.by_time[i])) * side;
            if (!(first < 0.0 && last > 0.0))
                continue;
            high *= first / (first - last);
            const struct moved lowest = move(q, dq, held, mode, p, high);
#if STATES
            after = mode_after(mode, &lowest);
            if (switches_at(lowest.q, lowest.dq, &after, p).value[i] * side >= 0.0)
                continue;
#else
            if (switches_at(lowest.q, lowest.dq, mode, p MOVING_(, held, high)).value[i] * side >= 0.0)
                continue;
#endif
        }
        *span = change_of(i, q, dq, held, mode, p, high);
        *end = move(q, dq, held, mode, p, *span);
#if STATES
        after = mode_after(mode, end);
        t = switches_at(end->q, end->dq, &after, p);
#else
        t = switches_at(end->q, end->dq, mode, p MOVING_(, held, *span));
#endif
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
#if MOVING
    if (switches_at(q, dq, &mode, p, held, 0.0).by_time[i] != 0.0)
        return 0;
#endif
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
    choose_sides(q, *dq, mode, p, i + 1 MOVING_(, held));
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
#if STATES
        const struct mode after = mode_after(mode, end);
        if (rate_at(end->q, end->dq, held, &after, p) * *span <= 2.0 * RESOLVED)
            return DONE;
#else
        if (rate_at(end->q, end->dq, held, mode, p) * *span <= 2.0 * RESOLVED)
            return DONE;
#endif
        if (2.0 * MOST_STEPS * *span < whole)
            return isfinite(end->q) && isfinite(end->dq) ? UNRESOLVED : NOT_FINITE;
        *span *= 0.5;
    }
}
#endif

/* Move for `whole` seconds through every change of the mode. */
static int advance(double *q, double *dq, struct mode *mode, double *held, const double *p,
                   double whole SIDES_(, ptrdiff_t *steps))
{
    double left = whole;
    for (int event = 0; event < MOST_EVENTS;) {
        const double before = *q, direction = mode->direction;
        const int from_rest = *dq == 0.0;
        double span = left;
        if (fabs(direction) < 1.0) {
            span = breakaway(*q, held, mode, p, left);
#if MOVING
            struct moved still = {*q, 0.0, 0.0, 0.0};
            const int met = passes(*q, 0.0, held, mode, p, &span, &still);
#endif
            pass(held, span);
            left -= span;
#if MOVING
            if (met >= 0) {
                mode->sides[met] = -mode->sides[met];
                choose_sides(*q, 0.0, mode, p, met + 1, held);
            } else
#endif
            if (left <= 0.0) {
#if LAGGED
                mode->direction = at_rest(*q, held, mode, p);
#else
#if SIGNALS
                mode->direction = at_rest(*q, held, mode, p);
#else
#if CONTINUOUS
                mode->direction = at_rest(*q, held, mode, p);
#endif
#endif
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
        if (--*steps < 0)
            return UNRESOLVED;
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
#if STATES
        copy_states(mode->states, end.states);
#endif
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
    found += strays(q, dq, end, mode, p MOVING_(, held, step)) + hurries(q, dq, end, held, mode, p, step);
#else
    (void)q, (void)dq, (void)held, (void)p, (void)step;
#endif
    return found;
}

