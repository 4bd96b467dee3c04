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

