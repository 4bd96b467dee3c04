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
enum { REGISTER = 8 }; /* lanes of the widest vector register */
enum { AT_LEAST_1_MEMORY = MEMORY + !MEMORY };

struct mode {
    double direction; /* strictly between -1 and 1 if the axis sticks */
#if SIDES
    double sides[SIDES]; /* -1 or 1; 0 if the axis rests in the place itself */
#endif
#if STATES
    double states[STATES]; /* what friction remembers, where the motion is */
#endif
};

#if SIDES
#define IN(mode) (mode)->direction, (mode)->sides/*STATES , (mode)->states*/
#else
#define IN(mode) (mode)->direction/*STATES , (mode)->states*/
#endif

/* A motion after a step, and its acceleration at both ends. */
struct moved {
    double q, dq, first, last;
#if STATES
    double states[STATES];
#endif
};
#if STATES

static inline void copy_states(double *to, const double *from)
{
    for (int i = 0; i < STATES; ++i)
        to[i] = from[i];
}

/* The mode of a motion after a step in another. */
static inline struct mode mode_after(const struct mode *mode, const struct moved *end)
{
    struct mode after = *mode;
    copy_states(after.states, end->states);
    return after;
}
#endif

static inline struct moved move(double q, double dq, const double *held, const struct mode *mode,
                                const double *p, double step)
{
#if MOVING
    if (fabs(mode->direction) < 1.0)
        return (struct moved){q, 0.0, 0.0, 0.0};
#endif
    struct moved end;
    plant_step(q, dq, held, IN(mode), p, step, &end.q, &end.dq, &end.first, &end.last/*STATES ,
               end.states*/);
    return end;
}

#if SIDES
#define AT_START (RESOLVED * (1.0 + 1e-6)) /* so that rounding does not decide for round numbers */
#define CAUGHT (1.0 / 1024.0)                 /* of a step */
enum { MOST_STEPS = 16384 };

/* Steps that a simulation may take in all. */
static ptrdiff_t steps_in_all(ptrdiff_t samples)
{
    return samples * STEPS_OF_EACH > STEPS_IN_ALL ? samples * STEPS_OF_EACH : STEPS_IN_ALL;
}

/* What decides the sides, and how it changes with the position and the velocity. */
struct switches {
    double value[SIDES], by_position[SIDES], by_velocity[SIDES];
#if MOVING
    double by_time[SIDES];
#endif
};

#if MOVING
/* The same with places that recorded signals move, `after` seconds later. */
static inline struct switches switches_at(double q, double dq, const struct mode *mode,
                                          const double *p, const double *held, double after)
{
    struct switches s;
    switching(q, dq, held, mode->sides, p, after, s.value, s.by_position, s.by_velocity,
              s.by_time);
    return s;
}
#else
static inline struct switches switches_at(double q, double dq, const struct mode *mode,
                                          const double *p)
{
    struct switches s;
    switching(q, dq, mode->sides/*STATES , mode->states*/, p, s.value, s.by_position, s.by_velocity);
    return s;
}
#endif

/* The sides at a state; one may depend on those before it. */
static void choose_sides(double q, double dq, struct mode *mode, const double *p, int first/*MOVING ,
                         const double *held*/)
{
#if FIRST_LIMIT
    for (int i = first; i < FIRST_LIMIT; ++i) {
#else
    for (int i = first; i < SIDES; ++i) {
#endif
        const struct switches s = switches_at(q, dq, mode, p/*MOVING , held, 0.0*/);
        if (s.value[i] != 0.0)
            mode->sides[i] = sign(s.value[i]);
        else if (mode->sides[i] == 0.0) /* it begins in the place: it leaves as it moves */
            mode->sides[i] = sign(s.by_position[i] * dq);
    }
}
#if MOVING

/* What is held, as far as places ask for it: the recorded signals. */
static void hold_lines(double *held, const double *recorded)
{
    for (int i = 0; i < HELD - 2 * SIGNALS; ++i)
        held[i] = 0.0;
    for (int i = 0; i < 2 * SIGNALS; ++i)
        held[HELD - 2 * SIGNALS + i] = recorded[i];
}

/* The sides at a sample from which recorded signals go on otherwise than before it. */
static void choose_shifted(double q, double dq, struct mode *mode, const double *p,
                           const double *last, const double *now, double period)
{
    double before[HELD], held[HELD];
    hold_lines(before, last);
    hold_lines(held, now);
    const struct switches then = switches_at(q, dq, mode, p, before, period);
    for (int i = 0; i < SIDES; ++i) {
        const struct switches s = switches_at(q, dq, mode, p, held, 0.0);
        if (s.value[i] == then.value[i] && s.by_time[i] == 0.0)
            continue;
        if (s.value[i] != 0.0)
            mode->sides[i] = sign(s.value[i]);
        else if (mode->sides[i] == 0.0)
            mode->sides[i] = sign(s.by_time[i]);
    }
}

/* The sides of places in which the axis begins that move, and what is held there. */
static void first_places(double q, double dq, struct mode *mode, const double *p,
                         const double *recorded, double *held)
{
    const double nothing[2 * SIGNALS] = {0.0};
    choose_shifted(q, dq, mode, p, nothing, recorded, 0.0);
    hold_lines(held, recorded);
}
#endif

/* The sides of an axis that leaves rest: where it rested in a place, the one ahead of it. */
static void choose_ahead(double q, struct mode *mode, const double *p/*MOVING , const double *held*/)
{
    const struct switches s = switches_at(q, 0.0, mode, p/*MOVING , held, 0.0*/);
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
                            const double *p/*MOVING , const double *held, double step*/)
{
    const struct switches s = switches_at(q, dq, mode, p/*MOVING , held, 0.0*/);
#if STATES
    const struct mode after = mode_after(mode, end);
    const struct switches t = switches_at(end->q, end->dq, &after, p);
#else
    const struct switches t = switches_at(end->q, end->dq, mode, p/*MOVING , held, step*/);
#endif
    double changes = 0.0;
    for (int i = 0; i < SIDES; ++i) {
        const double side = mode->sides[i];
        const double first = (s.by_position[i] * dq + s.by_velocity[i] * end->first/*MOVING  +
                              s.by_time[i]*/) * side;
        const double last = (t.by_position[i] * end->dq + t.by_velocity[i] * end->last/*MOVING  +
                              t.by_time[i]*/) * side;
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
#if STATES
    const struct mode after = mode_after(mode, end);
    return first + (rate_at(end->q, end->dq, held, &after, p) * step <= 2.0 * RESOLVED ? 0.0 : 1.0);
#else
    return first + (rate_at(end->q, end->dq, held, mode, p) * step <= 2.0 * RESOLVED ? 0.0 : 1.0);
#endif
}
#endif
#if FIRST_LIMIT

/* The sides of limits of states: one that is at its limit slips if the motion goes outwards. */
static void choose_slipping(double q, struct mode *mode, const double *p)
{
    const struct switches s = switches_at(q, 0.0, mode, p);
    for (int i = FIRST_LIMIT; i < SIDES; ++i)
        mode->sides[i] =
            s.value[i] <= 0.0 && s.by_position[i] * mode->direction < 0.0 ? -1.0 : 1.0;
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
    choose_ahead(q, &ahead, p/*MOVING , held*/);
    choose_ahead(q, &behind, p/*MOVING , held*/);
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
        choose_ahead(q, mode, p/*MOVING , held*/);
#endif
#if FIRST_LIMIT
    choose_slipping(q, mode, p);
#endif
}

