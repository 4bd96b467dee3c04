#if HOLDS_FORCE

/* Where motions are, and in which direction, some time after the law was evaluated, less than until
   it is again: each goes on from its position and velocity under what is held since then, in steps
   of at most `step`. Not a number where a motion comes to no end. */
void later_rows(ptrdiff_t rows, const double *position, const double *velocity, const double *held,
                const double *span, double step, const double *parameters, double *later_position,
                double *later_velocity, double *direction)
{
    for (ptrdiff_t l = 0; l < rows; ++l) {
        double q = position[l], dq = velocity[l], now[HELD];
        for (int i = 0; i < HELD; ++i)
            now[i] = held[l * HELD + i];
        struct mode mode = {.direction = sign(dq)};
#if MOVING
        double first[HELD];
        first_places(q, dq, &mode, parameters, now + HELD - 2 * SIGNALS, first);
#endif
#if SIDES
        choose_sides(q, dq, &mode, parameters, 0 MOVING_(, first));
#endif
        const double steps = ceil(span[l] / step);
        int status = DONE;
#if SIDES
        ptrdiff_t left = steps_in_all(1);
#endif
        for (double i = 0.0; i < steps && status == DONE; ++i) {
            if (dq == 0.0)
                choose_at_rest(q, now, &mode, parameters);
            status = advance(&q, &dq, &mode, now, parameters, span[l] / steps SIDES_(, &left));
        }
        later_position[l] = status == DONE ? q : NAN;
        later_velocity[l] = status == DONE ? dq : NAN;
        direction[l] = status == DONE ? mode.direction : NAN;
    }
}
#endif
