/* The EMPS loop as one would write it by hand: the yardstick of benchmarks/speed.py.

   The same arithmetic as the generated code: the recovered control law, one classical Runge-Kutta step
   a sample, Coulomb friction by Filippov's rule with located crossings. `scalar` is one simulation,
   `vector` is 32 side by side in vector registers, with a lane that meets an event finished alone. */

#include <math.h>
#include <stddef.h>

#define GAIN 35.15065188248547
#define KP 160.18
#define KV 243.45
#define LIMIT 10.0
#define LANES 32

typedef struct {
    double w, Fv, Fc, offset; /* w = 1/M: nobody divides by the mass four times a step */
} Axis;

static double clip(double u)
{
    u = u < LIMIT ? u : LIMIT;
    return u > -LIMIT ? u : -LIMIT;
}

static void rk4(double *q, double *dq, double push, double h, const Axis *a)
{
    const double v = *dq, k1 = (push - a->Fv * v) * a->w;
    const double v2 = v + 0.5 * h * k1, k2 = (push - a->Fv * v2) * a->w;
    const double v3 = v + 0.5 * h * k2, k3 = (push - a->Fv * v3) * a->w;
    const double v4 = v + h * k3, k4 = (push - a->Fv * v4) * a->w;
    *q += h * (1.0 / 6.0) * (v + v4 + 2.0 * (v2 + v3));
    *dq += h * (1.0 / 6.0) * (k1 + k4 + 2.0 * (k2 + k3));
}

static double direction_at_rest(double tau, const Axis *a)
{
    const double push = tau - a->offset;
    return push > a->Fc ? 1.0 : push < -a->Fc ? -1.0 : push / a->Fc;
}

static void move_with_events(double *q, double *dq, double tau, double h, const Axis *a, double *s)
{
    double left = h;
    *s = *dq > 0.0 ? 1.0 : *dq < 0.0 ? -1.0 : direction_at_rest(tau, a);
    while (left > 0.0 && fabs(*s) >= 1.0) {
        const double push = tau - a->offset - a->Fc * *s;
        double q1 = *q, v1 = *dq, low = 0.0, high = left;
        rk4(&q1, &v1, push, left, a);
        if (v1 * *s >= 0.0) {
            *q = q1;
            *dq = v1;
            return;
        }
        for (int i = 0; i < 60 && high - low > 1e-18; ++i) {
            const double middle = 0.5 * (low + high);
            q1 = *q;
            v1 = *dq;
            rk4(&q1, &v1, push, middle, a);
            if (v1 * *s > 0.0)
                low = middle;
            else
                high = middle;
        }
        q1 = *q;
        v1 = *dq;
        rk4(&q1, &v1, push, high, a);
        *q = q1;
        *dq = 0.0;
        left -= high;
        *s = direction_at_rest(tau, a);
    }
}

void scalar(ptrdiff_t n, const double *reference, const double *p, double h, double start,
            double *position, double *velocity, double *acceleration, double *force,
            double *control)
{
    const Axis a = {1.0 / p[0], p[1], p[2], p[3]};
    double q = start, dq = 0.0, q1 = start, q2 = start;
    for (ptrdiff_t k = 0; k < n; ++k) {
        const double u = clip(KV * (KP * (reference[k] - q) - (q - q2) * (1.0 / (2.0 * 0.001))));
        const double tau = GAIN * u;
        double s = (double)((dq > 0.0) - (dq < 0.0)), next = q, speed = dq;
        position[k] = q;
        velocity[k] = dq;
        control[k] = u;
        force[k] = tau;
        rk4(&next, &speed, tau - a.offset - a.Fc * s, h, &a);
        acceleration[k] = (tau - a.offset - a.Fc * s - a.Fv * dq) * a.w;
        q2 = q1;
        q1 = q;
        if (s == 0.0 || speed * s < 0.0) {
            const double v = dq;
            double end;
            s = v != 0.0 ? s : direction_at_rest(tau, &a);
            acceleration[k] = fabs(s) < 1.0 ? 0.0 : (tau - a.offset - a.Fc * s - a.Fv * v) * a.w;
            next = q;
            speed = v;
            move_with_events(&next, &speed, tau, h, &a, &end);
        }
        q = next;
        dq = speed;
    }
}

enum { WIDTH = 8, GROUPS = LANES / WIDTH };
typedef double Vector __attribute__((vector_size(8 * WIDTH)));
typedef long Mask __attribute__((vector_size(8 * WIDTH)));
typedef double Anywhere __attribute__((vector_size(8 * WIDTH), aligned(8)));

typedef struct {
    Vector w, Fv, Fc, offset, q, dq, q1, q2;
} Group;

static inline Vector choose(Mask m, Vector a, Vector b)
{
    return (Vector)((m & (Mask)a) | (~m & (Mask)b));
}

/* One sample of one register full of lanes; the force that was held. */
static inline Vector sample(Group *g, double reference, double h)
{
    const Vector zero = {0}, one = zero + 1.0;
    Vector u = KV * (KP * (reference - g->q) - (g->q - g->q2) * (1.0 / (2.0 * 0.001)));
    u = choose(u < LIMIT, u, zero + LIMIT);
    u = choose(u > -LIMIT, u, zero - LIMIT);
    const Vector tau = GAIN * u, dq = g->dq;
    const Vector s = choose(dq > zero, one, choose(dq < zero, -one, zero));
    const Vector push = tau - g->offset - g->Fc * s;
    const Vector k1 = (push - g->Fv * dq) * g->w, v2 = dq + 0.5 * h * k1;
    const Vector k2 = (push - g->Fv * v2) * g->w, v3 = dq + 0.5 * h * k2;
    const Vector k3 = (push - g->Fv * v3) * g->w, v4 = dq + h * k3;
    const Vector k4 = (push - g->Fv * v4) * g->w;
    Vector next = g->q + h * (1.0 / 6.0) * (dq + v4 + 2.0 * (v2 + v3));
    Vector speed = dq + h * (1.0 / 6.0) * (k1 + k4 + 2.0 * (k2 + k3));
    const Mask event = ~(speed * s > zero);
    long any = 0;
    for (int l = 0; l < WIDTH; ++l)
        any |= event[l];
    if (any)
        for (int l = 0; l < WIDTH; ++l)
            if (event[l]) {
                const Axis a = {g->w[l], g->Fv[l], g->Fc[l], g->offset[l]};
                double x = g->q[l], v = dq[l], mode;
                move_with_events(&x, &v, tau[l], h, &a, &mode);
                next[l] = x;
                speed[l] = v;
            }
    g->q2 = g->q1;
    g->q1 = g->q;
    g->q = next;
    g->dq = speed;
    return tau;
}

/* LANES simulations with one reference; parameters[4][LANES]; results [n][LANES]. */
void vector(ptrdiff_t n, const double *reference, const double *parameters, double h, double start,
            double *position, double *force)
{
    Group groups[GROUPS];
    for (int l = 0; l < LANES; ++l) {
        Group *g = groups + l / WIDTH;
        const int i = l % WIDTH;
        g->w[i] = 1.0 / parameters[l];
        g->Fv[i] = parameters[LANES + l];
        g->Fc[i] = parameters[2 * LANES + l];
        g->offset[i] = parameters[3 * LANES + l];
        g->q[i] = g->q1[i] = g->q2[i] = start;
        g->dq[i] = 0.0;
    }
    for (ptrdiff_t k = 0; k < n; ++k)
        for (int j = 0; j < GROUPS; ++j) {
            *(Anywhere *)(position + k * LANES + j * WIDTH) = groups[j].q;
            *(Anywhere *)(force + k * LANES + j * WIDTH) = sample(groups + j, reference[k], h);
        }
}
