/* What rows are made of: a measured motion with its control, or a simulated loop. */
struct source {
    ptrdiff_t samples, lanes;
    const double *position, *velocity, *acceleration, *force, *direction, *before, *parameters;
    double delay;
    const unsigned char *excluded;
};

/* How rows are filtered and thinned. The filter, forward and backward, is a sum of modes that run
   forward and modes that run backward: pairs of conjugate poles, each with its powers up to
   `every`. Rows are ends of blocks of `every` samples; `from` is the end of the first block, rows
   begin with block `skipped`. Samples outside `low` to `high` have no weight. */
struct thinning {
    ptrdiff_t start, samples, low, high, padding, every, from, skipped, blocks, rows;
    const double *powers, *gains, *settled, *ends;
    double direct;
};

enum { PAIRS = 4, STATES = 2 * PAIRS, STRETCH = 16 };

static inline void row_of(double q, double dq, double ddq, double direction, double *row)
{
    idm_regressor(q, dq, ddq, direction, row, row + PARAMETERS); /* what is known comes last */
}

enum kind { MEASURED, SIMULATED, ONES };
enum { STREAMS = 7, AHEAD = 40 };

/* What is worked with: streams of the samples of a block, WIDE lanes each, and two sets of rows. */
struct bench {
    double *streams[STREAMS];
    wide *values, *others;
};

/* Lanes of samples, or of those before them; what comes next is asked of memory ahead of time. */
static void gather(double *restrict to, const double *from, const struct source *s,
                   ptrdiff_t first, ptrdiff_t count, const ptrdiff_t *at, ptrdiff_t size,
                   ptrdiff_t before)
{
    const ptrdiff_t lanes = s->lanes, end = s->samples - 1;
    for (ptrdiff_t j = 0; j < size; ++j) {
        const ptrdiff_t k = at[j] > before ? at[j] - before : 0;
        __builtin_prefetch(from + (k + AHEAD < end ? k + AHEAD : end) * lanes + first);
        const wide found = load(from + k * lanes + first, count);
        memcpy(to + j * WIDE, &found, sizeof found);
    }
}

/* Rows of samples of lanes: regressor, what no parameter scales, and the force. */
static void measured_rows(const struct source *s, ptrdiff_t first, ptrdiff_t count,
                          const ptrdiff_t *at, ptrdiff_t size, double *const *stream,
                          double *restrict values)
{
    const double *const from[] = {s->position, s->velocity, s->acceleration, s->force,
                                  s->position, s->velocity, s->force};
    for (int m = 0; m < STREAMS; ++m)
        gather(stream[m], from[m], s, first, count, at, size, m > 3);
    const double *restrict q = stream[0], *restrict dq = stream[1], *restrict ddq = stream[2];
    const double *restrict u = stream[3], *restrict q0 = stream[4], *restrict dq0 = stream[5];
    const double *restrict u0 = stream[6];
    const double own = 1 - s->delay, other = s->delay;
    const ptrdiff_t all = size * WIDE;
    for (ptrdiff_t e = 0; e < all; ++e) {
        double row[PARAMETERS + 1], now, before;
        row_of(q[e], dq[e], ddq[e], (double)((dq[e] > 0.0) - (dq[e] < 0.0)), row);
        drive_force(u[e], q[e], dq[e], &now);
        drive_force(u0[e], q0[e], dq0[e], &before);
        for (int c = 0; c < PARAMETERS + KNOWN; ++c)
            values[c * all + e] = row[c];
        values[(PARAMETERS + KNOWN) * all + e] = other != 0.0 ? own * now + other * before : now;
    }
}

/* The same of simulated loops, without the force; the mean of just before and just after. */
static void simulated_rows(const struct source *s, ptrdiff_t first, ptrdiff_t count,
                           const ptrdiff_t *at, ptrdiff_t size, double *const *stream,
                           double *restrict values)
{
    const double *const from[] = {s->position,  s->velocity, s->acceleration,
                                  s->direction, s->force,    s->before};
    for (int m = 0; m < (s->before ? 6 : 4); ++m)
        gather(stream[m], from[m], s, first, count, at, size, m == 4);
    const double *restrict q = stream[0], *restrict dq = stream[1], *restrict ddq = stream[2];
    const double *restrict now = stream[3], *restrict held = stream[4];
    const double *restrict before = stream[5];
    const ptrdiff_t all = size * WIDE;
    if (!s->before) {
        for (ptrdiff_t e = 0; e < all; ++e) {
            double row[PARAMETERS + 1];
            row_of(q[e], dq[e], ddq[e], now[e], row);
            for (int c = 0; c < PARAMETERS + KNOWN; ++c)
                values[c * all + e] = row[c];
        }
        return;
    }
    double parameters[PARAMETERS][WIDE];
    for (int j = 0; j < PARAMETERS; ++j) {
        const wide found = load(s->parameters + j * s->lanes + first, count);
        memcpy(parameters[j], &found, sizeof found);
    }
    for (ptrdiff_t j = 0; j < size; ++j)
        for (int l = 0; l < WIDE; ++l) { /* so that parameters are registers, not looked up */
            double row[PARAMETERS + 1], earlier[PARAMETERS + 1], p[PARAMETERS], slowed;
            const ptrdiff_t e = j * WIDE + l;
            for (int i = 0; i < PARAMETERS; ++i)
                p[i] = parameters[i][l];
            row_of(q[e], dq[e], ddq[e], now[e], row);
            direct_dynamics(q[e], dq[e], held[e], before[e], p, &slowed);
            row_of(q[e], dq[e], slowed, before[e], earlier);
            for (int c = 0; c < PARAMETERS + KNOWN; ++c)
                values[c * all + e] = (row[c] + earlier[c]) / 2;
        }
}

/* Rows of samples, `size` of each column in turn, with what has no weight set to zero. */
static inline void weighted_rows(enum kind kind, const struct source *s, const struct thinning *t,
                                 ptrdiff_t first, ptrdiff_t count, const ptrdiff_t *at,
                                 int columns, double *const *stream, wide *values)
{
    const ptrdiff_t size = t->every;
    if (kind == MEASURED)
        measured_rows(s, first, count, at, size, stream, (double *)values);
    else if (kind == SIMULATED)
        simulated_rows(s, first, count, at, size, stream, (double *)values);
    else
        for (ptrdiff_t j = 0; j < size; ++j)
            values[j] = (wide){0} + 1.0;
    for (ptrdiff_t j = 0; j < size; ++j) {
        const ptrdiff_t i = at[j] - t->start;
        unsigned char gone[WIDE] = {0};
        unsigned long long any = 0;
        if (i < t->low || i >= t->high)
            memset(gone, 1, WIDE);
        else if (s->excluded)
            memcpy(gone, s->excluded + at[j] * s->lanes + first,
                   (size_t)(count < WIDE ? count : WIDE));
        memcpy(&any, gone, sizeof any);
        if (any)
            for (int c = 0; c < columns; ++c)
                for (int l = 0; l < WIDE; ++l)
                    if (gone[l])
                        values[c * size + j][l] = 0.0;
    }
}

/* The rows of a block that ends with `last`; beyond the ends of the stretch odd extensions, and
   then what is there last. */
static void block_rows(enum kind kind, const struct source *s, const struct thinning *t,
                              ptrdiff_t last, ptrdiff_t first, ptrdiff_t count, int columns,
                              const struct bench *w, ptrdiff_t *at)
{
    const ptrdiff_t size = t->every, end = t->samples - 1;
    for (ptrdiff_t j = 0; j < size; ++j) {
        const ptrdiff_t i = last - j;
        at[j] = (i < 0 ? 0 : i > end ? end : i) + t->start;
    }
    weighted_rows(kind, s, t, first, count, at, columns, w->streams, w->values);
    if (last - size >= -1 && last <= end)
        return;
    for (ptrdiff_t j = 0; j < size; ++j) {
        const ptrdiff_t i = last - j, away = i < 0 ? -i : i > end ? i - end : 0;
        const ptrdiff_t within = away < t->padding ? away : t->padding;
        at[j] = (i < 0 ? within : i > end ? end - within : i) + t->start;
    }
    weighted_rows(kind, s, t, first, count, at, columns, w->streams, w->others);
    for (ptrdiff_t j = 0; j < size; ++j)
        if (last - j < 0 || last - j > end)
            for (int c = 0; c < columns; ++c)
                w->values[c * size + j] = 2 * w->values[c * size + j] - w->others[c * size + j];
}

/* Real and imaginary part of a state one block later, and what came in the meantime. */
static inline void advance_state(wide *state, const double *whole, const wide *added)
{
    for (int m = 0; m < PAIRS; ++m) {
        const wide re = state[2 * m], im = state[2 * m + 1];
        state[2 * m] = whole[2 * m] * re - whole[2 * m + 1] * im + added[2 * m];
        state[2 * m + 1] = whole[2 * m] * im + whole[2 * m + 1] * re + added[2 * m + 1];
    }
}

static inline wide output_of(const wide *state, const double *gains)
{
    wide sum = gains[0] * state[0];
    for (int i = 1; i < STATES; ++i)
        sum += gains[i] * state[i];
    return sum;
}

/* Sums over a block's values, the last first, by powers of the modes: forward and backward. */
static inline void sum_block(const wide *values, ptrdiff_t every, const double *powers,
                             wide *forward, wide *backward)
{
    wide f[STATES], g[STATES];
    for (int i = 0; i < STATES; ++i)
        f[i] = g[i] = (wide){0};
    for (ptrdiff_t j = 0; j < every; ++j) {
        const wide x = values[j];
        const double *ahead = powers + STATES * j, *behind = powers + STATES * (every - j);
        for (int i = 0; i < STATES; ++i) {
            f[i] += ahead[i] * x;
            g[i] += behind[i] * x;
        }
    }
    memcpy(forward, f, sizeof f);
    memcpy(backward, g, sizeof g);
}

/* The modes that run backward, behind the last value, which goes on: all that is to come. */
static inline void turn_round(wide *state, wide last, const struct thinning *t)
{
    wide off[STATES];
    for (int i = 0; i < STATES; ++i)
        off[i] = state[i] - t->settled[i] * last;
    for (int i = 0; i < STATES; ++i) {
        state[i] = (t->settled[i] - (double)(i % 2 == 0)) * last;
        for (int k = 0; k < STATES; ++k)
            state[i] += t->ends[STATES * i + k] * off[k];
    }
}

/* One block of WIDE lanes: the modes that run forward go on by it, and are put into its row. */
static inline void pass_block(const int columns, const struct source *s, const struct thinning *t,
                              ptrdiff_t b, ptrdiff_t first, wide (*state)[STATES],
                              const wide *values, wide (*backward)[STATES], double *out)
{
    const ptrdiff_t every = t->every, row = b - t->skipped;
    for (int c = 0; c < columns; ++c, values += every) {
        wide forward[STATES];
        if (b < 0) { /* as after a long time of the first value */
            for (int i = 0; i < STATES; ++i)
                state[c][i] = t->settled[i] * *values;
            continue;
        }
        sum_block(values, every, t->powers, forward, backward[c]);
        advance_state(state[c], t->powers + STATES * every, forward);
        if (row >= 0 && row < t->rows)
            store(out + (row * columns + c) * s->lanes + first,
                  output_of(state[c], t->gains) + t->direct * *values, s->lanes - first);
        if (b == t->blocks - 1)
            turn_round(state[c], *values, t);
    }
}

/* The modes that run backward through the blocks from `begin` to before `end`: what they have at
   the end is added to the rows, and goes on to the begin. */
static inline void go_back(const int columns, const struct source *s, const struct thinning *t,
                           ptrdiff_t begin, ptrdiff_t end, ptrdiff_t first, wide (*state)[STATES],
                           wide (*backward)[STATES], double *out)
{
    static const wide nothing[STATES];
    const ptrdiff_t count = s->lanes - first;
    for (ptrdiff_t b = end - 1; b >= begin; --b) {
        const ptrdiff_t row = b - t->skipped;
        for (int c = 0; c < columns; ++c) {
            if (row >= 0 && row < t->rows) {
                double *place = out + (row * columns + c) * s->lanes + first;
                store(place, load(place, count) + output_of(state[c], t->gains), count);
            }
            advance_state(state[c], t->powers + STATES * t->every,
                          backward ? backward[(b - begin) * columns + c] : nothing);
        }
    }
}

/* Columns of lanes, filtered and thinned, (rows, columns, lanes). `work` holds WIDE times
   (STREAMS + 2 COLUMNS + 1) blocks and one value, and of a column of WIDE lanes STATES for each of
   STRETCH blocks, for each stretch of so many, and twice more. Memory is read once, as it lies:
   what runs backward is worked out within a stretch, and what of it goes further is kept. */
static inline void thin(enum kind kind, const int columns, const struct source *s,
                        const struct thinning *t, double *out, double *work)
{
    const ptrdiff_t every = t->every, groups = (s->lanes + WIDE - 1) / WIDE;
    work = aligned(work);
    struct bench w = {.values = (wide *)(work + STREAMS * every * WIDE)};
    w.others = w.values + COLUMNS * every;
    ptrdiff_t *at = (ptrdiff_t *)(w.others + COLUMNS * every);
    wide(*state)[STATES] = (wide(*)[STATES])(w.others + (COLUMNS + 1) * every);
    wide(*within)[STATES] = state + groups * columns;
    wide(*kept)[STATES] = within + STRETCH * groups * columns;
    const ptrdiff_t stretches = (t->blocks + STRETCH - 1) / STRETCH;
    for (int m = 0; m < STREAMS; ++m)
        w.streams[m] = work + m * every * WIDE;
    for (ptrdiff_t n = 0; n < stretches; ++n) {
        const ptrdiff_t begin = n * STRETCH;
        const ptrdiff_t end = begin + STRETCH < t->blocks ? begin + STRETCH : t->blocks;
        for (ptrdiff_t b = n ? begin : -1; b < end; ++b)
            for (ptrdiff_t g = 0; g < groups; ++g) {
                const ptrdiff_t first = g * WIDE, place = g * STRETCH + (b < 0 ? 0 : b - begin);
                block_rows(kind, s, t, t->from + b * every, first, s->lanes - first, columns, &w,
                           at);
                pass_block(columns, s, t, b, first, state + g * columns, w.values,
                           within + place * columns, out);
            }
        for (ptrdiff_t g = 0; g < groups; ++g) {
            wide(*found)[STATES] = kept + (n * groups + g) * columns;
            memset(found, 0, sizeof *found * (size_t)columns);
            go_back(columns, s, t, begin, end, g * WIDE, found, within + g * STRETCH * columns,
                    out);
        }
    }
    for (ptrdiff_t n = stretches - 1; n >= 0; --n)
        for (ptrdiff_t g = 0; g < groups; ++g) {
            const ptrdiff_t begin = n * STRETCH;
            const ptrdiff_t end = begin + STRETCH < t->blocks ? begin + STRETCH : t->blocks;
            go_back(columns, s, t, begin, end, g * WIDE, state + g * columns, NULL, out);
            for (int c = 0; c < columns; ++c)
                for (int i = 0; i < STATES; ++i)
                    state[g * columns + c][i] += kept[(n * groups + g) * columns + c][i];
        }
}

/* The settings of a thinning, as they come: whole numbers, and modes. */
static struct thinning thinning_of(const ptrdiff_t *sizes, const double *powers,
                                   const double *gains, const double *settled, const double *ends,
                                   double direct)
{
    const struct thinning t = {
        .start = sizes[0], .samples = sizes[1], .low = sizes[2], .high = sizes[3],
        .padding = sizes[4], .every = sizes[5], .from = sizes[6], .skipped = sizes[7],
        .blocks = sizes[8], .rows = sizes[9], .powers = powers, .gains = gains,
        .settled = settled, .ends = ends, .direct = direct,
    };
    return t;
}

void lanes_measured(ptrdiff_t samples, ptrdiff_t lanes, const double *control, const double *q,
                    const double *dq, const double *ddq, double delay,
                    const unsigned char *excluded, const ptrdiff_t *sizes, const double *powers,
                    const double *gains, const double *settled, const double *ends, double direct,
                    double *out, double *work)
{
    const struct source s = {.samples = samples, .lanes = lanes, .position = q, .velocity = dq,
                             .acceleration = ddq, .force = control, .delay = delay,
                             .excluded = excluded};
    const struct thinning t = thinning_of(sizes, powers, gains, settled, ends, direct);
    thin(MEASURED, COLUMNS, &s, &t, out, work);
}

void lanes_simulated(ptrdiff_t samples, ptrdiff_t lanes, const double *position,
                     const double *velocity, const double *acceleration, const double *force,
                     const double *direction, const double *before, const double *parameters,
                     const unsigned char *excluded, const ptrdiff_t *sizes, const double *powers,
                     const double *gains, const double *settled, const double *ends, double direct,
                     double *out, double *work)
{
    const struct source s = {.samples = samples, .lanes = lanes, .position = position,
                             .velocity = velocity, .acceleration = acceleration, .force = force,
                             .direction = direction, .before = before, .parameters = parameters,
                             .excluded = excluded};
    const struct thinning t = thinning_of(sizes, powers, gains, settled, ends, direct);
    thin(SIMULATED, COLUMNS - 1, &s, &t, out, work);
}

void lanes_weights(ptrdiff_t samples, ptrdiff_t lanes, const unsigned char *excluded,
                   const ptrdiff_t *sizes, const double *powers, const double *gains,
                   const double *settled, const double *ends, double direct, double *out,
                   double *work)
{
    const struct source s = {.samples = samples, .lanes = lanes, .excluded = excluded};
    const struct thinning t = thinning_of(sizes, powers, gains, settled, ends, direct);
    thin(ONES, 1, &s, &t, out, work);
}

