/* The quadratic of the adaptive observer's frozen-speed poles over many speeds, as a careful engineer would write it: the
   yardstick of `poles.py`. With x_d + j x_q for each vector it is s^2 + (R_s/sigma + k_1 - j w) s + alpha k_3 + k_2 w^2; the
   larger root first, the other from the product. p = R_s, sigma, alpha, k_1, k_2, k_3. */

#include <math.h>

void pole_pairs(long points, const double *omega, const double *p, double *re_1, double *im_1, double *re_2, double *im_2)
{
    double decay = p[0] / p[1] + p[3], still = p[2] * p[5], k_2 = p[4];
    for (long k = 0; k < points; k++) {
        double w = omega[k], p_im = -w, q_re = still + k_2 * w * w;
        double d_re = (decay - p_im) * (decay + p_im) - 4 * q_re, d_im = 2 * decay * p_im;
        double longer = sqrt(0.5 * (sqrt(d_re * d_re + d_im * d_im) + fabs(d_re)));
        double shorter = 0.5 * fabs(d_im) / (longer > 0 ? longer : 1.0);
        double w_re = d_re >= 0 ? longer : shorter, w_im = copysign(d_re >= 0 ? shorter : longer, d_im);
        double half = copysign(0.5, decay * w_re + p_im * w_im);
        double x = -0.5 * decay - half * w_re, y = -0.5 * p_im - half * w_im;
        double size = x * x + y * y;
        size = size > 0 ? size : 1.0;
        re_1[k] = x;
        im_1[k] = y;
        re_2[k] = q_re * x / size;
        im_2[k] = -q_re * y / size;
    }
}
