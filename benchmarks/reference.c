/* One closed loop written by hand: drive, machine (1) in the stationary frame and the repaired 8-state observer, RK4, one
   step a sample. The yardstick of the benchmark: what a careful engineer would write in C, operation for operation the same
   arithmetic as the definitions in imo_analysis/equations and imo_analysis/simulation/drive.py.

   p = R_s, L_m, sigma, beta, alpha, mu, n_p, J, B/n_p (machine), o = R_s, L_m, sigma, beta (observer),
   g = k_1, kappa, k_3, g, K_p, alpha_l, delta, d = T, w_current, w_flux, w_speed, u_max, i_max, flux_floor.
   x = i_ds, i_qs, phi_dr, phi_qr, omega and the observer's 8; c = 3 integrals, own flux (2) and its last rate (2). */

#include <math.h>

#define STATES 13

static inline void rates(const double *x, double u_d, double u_q, double T_l, double s, const double *p, const double *o,
                         const double *g, double *r)
{
    double R_s = p[0], L_m = p[1], sigma = p[2], beta = p[3], alpha = p[4], mu = p[5], n_p = p[6], J = p[7], friction = p[8];
    double i_d = x[0], i_q = x[1], phi_d = x[2], phi_q = x[3], w = x[4];
    double gamma = R_s / sigma + alpha * beta * L_m;
    r[0] = -gamma * i_d + beta * (alpha * phi_d + w * phi_q) + u_d / sigma;
    r[1] = -gamma * i_q + beta * (alpha * phi_q - w * phi_d) + u_q / sigma;
    r[2] = -alpha * phi_d - w * phi_q + alpha * L_m * i_d;
    r[3] = -alpha * phi_q + w * phi_d + alpha * L_m * i_q;
    r[4] = mu * (phi_d * i_q - phi_q * i_d) - n_p * (T_l + friction * w) / J;

    double id = x[5], iq = x[6], z1 = x[7], z2 = x[8], xi1 = x[9], xi2 = x[10], a = x[11], wh = x[12];
    double ed = i_d - id, eq = i_q - iq;
    double decay = -o[0] / o[2], coupling = 1.0 + o[3] * o[1], v_d = u_d / o[2], v_q = u_q / o[2];
    double v1d = xi1 - coupling * i_d, v1q = xi2 - coupling * i_q, v2d = z2 - iq, v2q = id - z1;
    r[5] = decay * id + a * v1d + wh * v2d + g[0] * ed + v_d;
    r[6] = decay * iq + a * v1q + wh * v2q + g[0] * eq + v_q;
    r[7] = decay * i_d - g[1] * s * eq + v_d;
    r[8] = decay * i_q + g[1] * s * ed + v_q;
    r[9] = decay * i_d + g[2] * ed + v_d;
    r[10] = decay * i_q + g[2] * eq + v_q;
    double rho = g[3] * (ed * v1d + eq * v1q);
    double layer = (g[5] * g[5] - a * a) / (2.0 * g[6] * g[5] - g[6] * g[6]);
    r[11] = rho + fmax(layer, 0.0) * fmax(-rho, 0.0);
    r[12] = g[4] * (ed * v2d + eq * v2q);
}

/* Inputs are rows of omega_ref, flux_ref, T_l and noise of each current, `stride` numbers apart; out has 17 columns. */
long run(long samples, long every, double bound, const double *inputs, long stride, const double *p, const double *o,
         const double *g, const double *d, double *x_0, double *c_0, double *out)
{
    double x[STATES], y[STATES], k1[STATES], k2[STATES], k3[STATES], k4[STATES];
    double R_s = p[0], L_m = p[1], sigma = p[2], beta = p[3], alpha = p[4], mu = p[5];
    double T = d[0], w_current = d[1], w_flux = d[2], w_speed = d[3], u_max = d[4], i_max = d[5], flux_floor = d[6];
    double integral_d = c_0[0], integral_q = c_0[1], integral_w = c_0[2];
    double f_d = c_0[3], f_q = c_0[4], flow_d = c_0[5], flow_q = c_0[6];
    double gain = w_current * sigma, decay = T * (R_s / sigma + alpha * beta * L_m), half = T / 2;
    long wait = 0, k;
    for (int j = 0; j < STATES; j++) x[j] = x_0[j];
    for (k = 0; k < samples; k++) {
        double sum = 0, sum_y = 0;
        for (int j = 0; j < 5; j++) sum += fabs(x[j]);
        for (int j = 5; j < STATES; j++) sum_y += fabs(x[j]);
        if (!(sum < bound) || !(sum_y < bound)) break;

        double n_d = inputs[3 * stride + k], n_q = inputs[4 * stride + k], omega = x[4];
        double i_ds = x[0] + n_d, i_qs = x[1] + n_q;
        /* field-oriented control */
        double magnitude = sqrt(f_d * f_d + f_q * f_q), inverse = 1.0 / fmax(magnitude, flux_floor);
        double c = f_d * inverse + (1.0 - magnitude * inverse), s = f_q * inverse;
        double i_d = c * i_ds + s * i_qs, i_q = c * i_qs - s * i_ds;
        double flux_ref = inputs[stride + k], omega_ref = inputs[k], T_l = inputs[2 * stride + k];
        double i_d_ref = fmin(fmax((flux_ref + (w_flux / alpha - 1.0) * (flux_ref - magnitude)) / L_m, -i_max), i_max);
        double acceleration = w_speed * omega_ref - 2.0 * w_speed * omega + integral_w;
        double amperes = inverse / mu, room = sqrt(i_max * i_max - i_d_ref * i_d_ref);
        double i_q_ref = fmin(fmax(acceleration * amperes, -room), room), reached = i_q_ref / amperes;
        integral_w += T * w_speed * (w_speed * (omega_ref - omega) + (reached - acceleration));
        double w_s = omega + alpha * L_m * i_q * inverse;
        double u_d = gain * (i_d_ref - i_d) + integral_d - sigma * (w_s * i_q + beta * alpha * magnitude);
        double u_q = gain * (i_q_ref - i_q) + integral_q + sigma * (w_s * i_d + beta * omega * magnitude);
        double scale = fmin(1.0, u_max / fmax(sqrt(u_d * u_d + u_q * u_q), 1e-9));
        integral_d += decay * (gain * (i_d_ref - i_d) + (scale - 1.0) * u_d);
        integral_q += decay * (gain * (i_q_ref - i_q) + (scale - 1.0) * u_q);
        u_d *= scale;
        u_q *= scale;
        double u_ds = c * u_d - s * u_q, u_qs = s * u_d + c * u_q;
        /* the drive's own flux at the next sample, Adams-Bashforth */
        double r_d = -alpha * f_d - omega * f_q + alpha * L_m * i_ds, r_q = -alpha * f_q + omega * f_d + alpha * L_m * i_qs;
        f_d += T * (1.5 * r_d - 0.5 * flow_d);
        f_q += T * (1.5 * r_q - 0.5 * flow_q);
        flow_d = r_d;
        flow_q = r_q;

        if (wait == 0) {
            for (int j = 0; j < 5; j++) out[j] = x[j];
            out[5] = u_ds, out[6] = u_qs, out[7] = i_ds, out[8] = i_qs;
            for (int j = 5; j < STATES; j++) out[4 + j] = x[j];
            out += 17;
            wait = every;
        }
        wait--;

        double direction = omega >= -1e-6 ? 1.0 : -1.0;
        rates(x, u_ds, u_qs, T_l, direction, p, o, g, k1);
        for (int j = 0; j < STATES; j++) y[j] = x[j] + half * k1[j];
        rates(y, u_ds, u_qs, T_l, direction, p, o, g, k2);
        for (int j = 0; j < STATES; j++) y[j] = x[j] + half * k2[j];
        rates(y, u_ds, u_qs, T_l, direction, p, o, g, k3);
        for (int j = 0; j < STATES; j++) y[j] = x[j] + T * k3[j];
        rates(y, u_ds, u_qs, T_l, direction, p, o, g, k4);
        for (int j = 0; j < STATES; j++) x[j] += T / 6 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]);
    }
    for (int j = 0; j < STATES; j++) x_0[j] = x[j];
    c_0[0] = integral_d, c_0[1] = integral_q, c_0[2] = integral_w;
    c_0[3] = f_d, c_0[4] = f_q, c_0[5] = flow_d, c_0[6] = flow_q;
    return k;
}
