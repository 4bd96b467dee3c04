/* The EMPS loop as one would write it by hand: the yardstick of benchmarks/simulation.py.

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
    double M, Fv, Fc, offset;
} Axis;

static double clip(double u)
{
    u = u < LIMIT ? u : LIMIT;
    return u > -LIMIT ? u : -LIMIT;
}

static void rk4(double *q, double *dq, double push, double h, const Axis *a)
{
    const double v = *dq, k1 = (push - a->Fv * v) / a->M;
    const double v2 = v + 0.5 * h * k1, k2 = (push - a->Fv * v2) / a->M;
    const double v3 = v + 0.5 * h * k2, k3 = (push - a->Fv * v3) / a->M;
    const double v4 = v + h * k3, k4 = (push - a->Fv * v4) / a->M;
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
    const Axis a = {p[0], p[1], p[2], p[3]};
    double q = start, dq = 0.0, q1 = start, q2 = start;
    for (ptrdiff_t k = 0; k < n; ++k) {
        const double u = clip(KV * (KP * (reference[k] - q) - (q - q2) / (2.0 * 0.001)));
        const double tau = GAIN * u;
        double s = (double)((dq > 0.0) - (dq < 0.0)), next = q, speed = dq;
        position[k] = q;
        velocity[k] = dq;
        control[k] = u;
        force[k] = tau;
        rk4(&next, &speed, tau - a.offset - a.Fc * s, h, &a);
        acceleration[k] = (tau - a.offset - a.Fc * s - a.Fv * dq) / a.M;
        q2 = q1;
        q1 = q;
        if (s == 0.0 || speed * s < 0.0) {
            const double v = dq;
            double end;
            s = v != 0.0 ? s : direction_at_rest(tau, &a);
            acceleration[k] = fabs(s) < 1.0 ? 0.0 : (tau - a.offset - a.Fc * s - a.Fv * v) / a.M;
            next = q;
            speed = v;
            move_with_events(&next, &speed, tau, h, &a, &end);
        }
        q = next;
        dq = speed;
    }
}

typedef double Vector __attribute__((vector_size(8 * LANES)));
typedef long Mask __attribute__((vector_size(8 * LANES)));
typedef double Anywhere __attribute__((vector_size(8 * LANES), aligned(8)));

static inline Vector choose(Mask m, Vector a, Vector b)
{
    return (Vector)((m & (Mask)a) | (~m & (Mask)b));
}

/* LANES simulations with one reference; parameters[4][LANES]; results [n][LANES]. */
void vector(ptrdiff_t n, const double *reference, const double *parameters, double h, double start,
            double *position, double *force)
{
    Vector M, Fv, Fc, offset, q, dq = {0}, q1, q2;
    for (int l = 0; l < LANES; ++l) {
        M[l] = parameters[l];
        Fv[l] = parameters[LANES + l];
        Fc[l] = parameters[2 * LANES + l];
        offset[l] = parameters[3 * LANES + l];
        q[l] = q1[l] = q2[l] = start;
    }
    const Vector zero = {0}, one = zero + 1.0;
    for (ptrdiff_t k = 0; k < n; ++k) {
        Vector u = KV * (KP * (reference[k] - q) - (q - q2) / (2.0 * 0.001));
        u = choose(u < LIMIT, u, zero + LIMIT);
        u = choose(u > -LIMIT, u, zero - LIMIT);
        const Vector tau = GAIN * u;
        const Vector s = choose(dq > zero, one, choose(dq < zero, -one, zero));
        const Vector push = tau - offset - Fc * s;
        const Vector k1 = (push - Fv * dq) / M, v2 = dq + 0.5 * h * k1;
        const Vector k2 = (push - Fv * v2) / M, v3 = dq + 0.5 * h * k2;
        const Vector k3 = (push - Fv * v3) / M, v4 = dq + h * k3, k4 = (push - Fv * v4) / M;
        Vector next = q + h * (1.0 / 6.0) * (dq + v4 + 2.0 * (v2 + v3));
        Vector speed = dq + h * (1.0 / 6.0) * (k1 + k4 + 2.0 * (k2 + k3));
        const Mask event = ~(speed * s > zero);
        long any = 0;
        for (int l = 0; l < LANES; ++l)
            any |= event[l];
        if (any)
            for (int l = 0; l < LANES; ++l)
                if (event[l]) {
                    const Axis a = {M[l], Fv[l], Fc[l], offset[l]};
                    double x = q[l], v = dq[l], mode;
                    move_with_events(&x, &v, tau[l], h, &a, &mode);
                    next[l] = x;
                    speed[l] = v;
                }
        *(Anywhere *)(position + k * LANES) = q;
        *(Anywhere *)(force + k * LANES) = tau;
        q2 = q1;
        q1 = q;
        q = next;
        dq = speed;
    }
}
