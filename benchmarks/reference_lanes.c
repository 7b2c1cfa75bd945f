/* The loop of reference.c for many machines at once, written by hand for the compiler's vectoriser: blocks of W machines, one
   array a quantity, everything that is constant in a run computed once, and divisions by constants turned into products.

   `machines` is a multiple of W. Arrays are row by row, `machines` numbers a row:
   p = R_s, L_m, sigma, beta, alpha, mu, n_p, J, B/n_p; o = R_s, L_m, sigma, beta; g = k_1, kappa, k_3, g, K_p, alpha_l, delta;
   x = the 13 states; c = 3 integrals, own flux (2) and its last rate (2); d as in reference.c, the same for all;
   sums = squared speed error, largest speed error, squared flux error, largest squared flux error. */

#include <math.h>

#ifndef W
#define W 16 /* the benchmark tries others and takes what is best on the machine at hand */
#endif
#define ROW(name, j) ((name)[(j) * machines + first + l])

enum { decay_p, v_p, gamma_p, beta_p, alpha_p, aL, mu_p, acc, friction_p, inv_alpha, inv_L, inv_mu, sigma_p, ba, leak,
       decay_o, coupling, v_o, k_1, kappa, k_3, gg, K_p, al2, inv_layer, beta_o, CONSTANTS };

static double pos(double v) { return v > 0 ? v : 0; }
static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

static inline double clip(double v, double limit) { return smaller(larger(v, -limit), limit); }

void run(long machines, long samples, long every, const double *inputs, long stride, const double *p, const double *o,
         const double *g, const double *d, double *x_0, double *c_0, double *sums_0)
{
    double T = d[0], w_current = d[1], w_speed = d[3], u_max = d[4], i_max = d[5], flux_floor = d[6], half = T / 2, sixth = T / 6;
    for (long first = 0; first < machines; first += W) {
        double q[CONSTANTS][W] __attribute__((aligned(64)));
        double x[13][W] __attribute__((aligned(64))), c[7][W] __attribute__((aligned(64))), sums[4][W] __attribute__((aligned(64)));
        double u[2][W] __attribute__((aligned(64))), dir[W] __attribute__((aligned(64)));
        for (int l = 0; l < W; l++) {
            double R_s = ROW(p, 0), L_m = ROW(p, 1), sigma = ROW(p, 2), beta = ROW(p, 3), alpha = ROW(p, 4), mu = ROW(p, 5);
            q[gamma_p][l] = R_s / sigma + alpha * beta * L_m;
            q[v_p][l] = 1 / sigma;
            q[beta_p][l] = beta;
            q[alpha_p][l] = alpha;
            q[aL][l] = alpha * L_m;
            q[mu_p][l] = mu;
            q[acc][l] = ROW(p, 6) / ROW(p, 7);
            q[friction_p][l] = ROW(p, 8);
            q[inv_alpha][l] = d[2] / alpha - 1;
            q[inv_L][l] = 1 / L_m;
            q[inv_mu][l] = 1 / mu;
            q[sigma_p][l] = sigma;
            q[ba][l] = beta * alpha;
            q[leak][l] = T * q[gamma_p][l];
            q[decay_o][l] = -ROW(o, 0) / ROW(o, 2);
            q[v_o][l] = 1 / ROW(o, 2);
            q[coupling][l] = 1 + ROW(o, 3) * ROW(o, 1);
            q[beta_o][l] = 1 / ROW(o, 3);
            for (int j = 0; j < 5; j++) q[k_1 + j][l] = ROW(g, j);
            q[al2][l] = ROW(g, 5) * ROW(g, 5);
            q[inv_layer][l] = 1 / (2 * ROW(g, 6) * ROW(g, 5) - ROW(g, 6) * ROW(g, 6));
            for (int j = 0; j < 13; j++) x[j][l] = ROW(x_0, j);
            for (int j = 0; j < 7; j++) c[j][l] = ROW(c_0, j);
            for (int j = 0; j < 4; j++) sums[j][l] = ROW(sums_0, j);
        }
        long wait = 0;
        for (long k = 0; k < samples; k++) {
            double omega_ref = inputs[k], flux_ref = inputs[stride + k], T_l = inputs[2 * stride + k];
            double n_d = inputs[3 * stride + k], n_q = inputs[4 * stride + k];
            #pragma omp simd
            for (int l = 0; l < W; l++) {
                double i_ds = x[0][l] + n_d, i_qs = x[1][l] + n_q, omega = x[4][l], f_d = c[3][l], f_q = c[4][l];
                double magnitude = sqrt(f_d * f_d + f_q * f_q), inverse = 1.0 / larger(magnitude, flux_floor);
                double cs = f_d * inverse + (1.0 - magnitude * inverse), sn = f_q * inverse;
                double i_d = cs * i_ds + sn * i_qs, i_q = cs * i_qs - sn * i_ds;
                double i_d_ref = clip((flux_ref + q[inv_alpha][l] * (flux_ref - magnitude)) * q[inv_L][l], i_max);
                double acceleration = w_speed * omega_ref - 2.0 * w_speed * omega + c[2][l];
                double amperes = inverse * q[inv_mu][l], room = sqrt(i_max * i_max - i_d_ref * i_d_ref);
                double i_q_ref = clip(acceleration * amperes, room), reached = i_q_ref / amperes;
                c[2][l] += T * w_speed * (w_speed * (omega_ref - omega) + (reached - acceleration));
                double w_s = omega + q[aL][l] * i_q * inverse, sigma = q[sigma_p][l], gain = w_current * sigma;
                double u_d = gain * (i_d_ref - i_d) + c[0][l] - sigma * (w_s * i_q + q[ba][l] * magnitude);
                double u_q = gain * (i_q_ref - i_q) + c[1][l] + sigma * (w_s * i_d + q[beta_p][l] * omega * magnitude);
                double scale = smaller(1.0, u_max / larger(sqrt(u_d * u_d + u_q * u_q), 1e-9));
                c[0][l] += q[leak][l] * (gain * (i_d_ref - i_d) + (scale - 1.0) * u_d);
                c[1][l] += q[leak][l] * (gain * (i_q_ref - i_q) + (scale - 1.0) * u_q);
                u_d *= scale;
                u_q *= scale;
                u[0][l] = cs * u_d - sn * u_q;
                u[1][l] = sn * u_d + cs * u_q;
                double r_d = -q[alpha_p][l] * f_d - omega * f_q + q[aL][l] * i_ds;
                double r_q = -q[alpha_p][l] * f_q + omega * f_d + q[aL][l] * i_qs;
                c[3][l] = f_d + T * (1.5 * r_d - 0.5 * c[5][l]);
                c[4][l] = f_q + T * (1.5 * r_q - 0.5 * c[6][l]);
                c[5][l] = r_d;
                c[6][l] = r_q;
                dir[l] = omega >= -1e-6 ? 1.0 : -1.0;
            }
            if (wait == 0) {
                wait = every;
                #pragma omp simd
                for (int l = 0; l < W; l++) {
                    double e = fabs(x[4][l] - x[12][l]), a = x[11][l], w = x[12][l];
                    double f = a * x[9][l] + w * x[8][l], h = a * x[10][l] - w * x[7][l], n = 1 / (a * a + w * w);
                    double p_d = x[2][l] - ((a * f - w * h) * n - x[0][l]) * q[beta_o][l];
                    double p_q = x[3][l] - ((w * f + a * h) * n - x[1][l]) * q[beta_o][l];
                    double f2 = p_d * p_d + p_q * p_q;
                    sums[0][l] += e * e;
                    sums[1][l] = larger(sums[1][l], e);
                    sums[2][l] += f2;
                    sums[3][l] = larger(sums[3][l], f2);
                }
            }
            wait--;
            #pragma omp simd
            for (int l = 0; l < W; l++) {
                double y[13], k[13], sum[13], v_pd = u[0][l] * q[v_p][l], v_pq = u[1][l] * q[v_p][l];
                double v_od = u[0][l] * q[v_o][l], v_oq = u[1][l] * q[v_o][l], s = dir[l] * q[kappa][l];
                for (int j = 0; j < 13; j++) y[j] = x[j][l];
                #pragma GCC unroll 4
                for (int stage = 0; stage < 4; stage++) {
                    double i_d = y[0], i_q = y[1], phi_d = y[2], phi_q = y[3], w = y[4];
                    double id = y[5], iq = y[6], z1 = y[7], z2 = y[8], xi1 = y[9], xi2 = y[10], a = y[11], wh = y[12];
                    double ed = i_d - id, eq = i_q - iq, D = q[decay_o][l], ci_d = q[coupling][l] * i_d, ci_q = q[coupling][l] * i_q;
                    double al = q[alpha_p][l], e1 = xi1 - ci_d, e2 = xi2 - ci_q, b1 = D * i_d + v_od, b2 = D * i_q + v_oq;
                    k[0] = -q[gamma_p][l] * i_d + q[beta_p][l] * (al * phi_d + w * phi_q) + v_pd;
                    k[1] = -q[gamma_p][l] * i_q + q[beta_p][l] * (al * phi_q - w * phi_d) + v_pq;
                    k[2] = -al * phi_d - w * phi_q + q[aL][l] * i_d;
                    k[3] = -al * phi_q + w * phi_d + q[aL][l] * i_q;
                    k[4] = q[mu_p][l] * (phi_d * i_q - phi_q * i_d) - q[acc][l] * (T_l + q[friction_p][l] * w);
                    k[5] = D * id + a * e1 + wh * (z2 - iq) + q[k_1][l] * ed + v_od;
                    k[6] = D * iq + a * e2 - wh * (z1 - id) + q[k_1][l] * eq + v_oq;
                    k[7] = b1 - s * eq;
                    k[8] = b2 + s * ed;
                    k[9] = b1 + q[k_3][l] * ed;
                    k[10] = b2 + q[k_3][l] * eq;
                    double rho = q[gg][l] * (ed * e1 + eq * e2);
                    k[11] = rho + pos((q[al2][l] - a * a) * q[inv_layer][l]) * pos(-rho);
                    k[12] = q[K_p][l] * ((z2 - iq) * ed - (z1 - id) * eq);
                    double h = stage < 2 ? half : T, weight = stage == 0 || stage == 3 ? 1.0 : 2.0;
                    for (int j = 0; j < 13; j++) sum[j] = stage ? sum[j] + weight * k[j] : k[j];
                    for (int j = 0; j < 13; j++) y[j] = x[j][l] + h * k[j];
                }
                for (int j = 0; j < 13; j++) x[j][l] += sixth * sum[j];
            }
        }
        for (int l = 0; l < W; l++) {
            for (int j = 0; j < 13; j++) ROW(x_0, j) = x[j][l];
            for (int j = 0; j < 7; j++) ROW(c_0, j) = c[j][l];
            for (int j = 0; j < 4; j++) ROW(sums_0, j) = sums[j][l];
        }
    }
}
