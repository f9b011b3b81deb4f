#include "adding_doubling.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace fluovox::reference {
namespace {

/// A square matrix.
class Matrix {
public:
    explicit Matrix(std::size_t n, double diagonal = 0) : n_(n), values_(n * n, 0) {
        for (std::size_t i = 0; i < n; ++i)
            (*this)(i, i) = diagonal;
    }
    double& operator()(std::size_t i, std::size_t j) { return values_[i * n_ + j]; }
    double operator()(std::size_t i, std::size_t j) const { return values_[i * n_ + j]; }
    std::size_t size() const { return n_; }

private:
    std::size_t n_;
    std::vector<double> values_;
};

Matrix sum(const Matrix& a, double factor, const Matrix& b) {
    Matrix c(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t j = 0; j < a.size(); ++j)
            c(i, j) = a(i, j) + factor * b(i, j);
    }
    return c;
}

Matrix operator*(const Matrix& a, const Matrix& b) {
    Matrix c(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t k = 0; k < a.size(); ++k) {
            for (std::size_t j = 0; j < a.size(); ++j)
                c(i, j) += a(i, k) * b(k, j);
        }
    }
    return c;
}

/// The row from `k` on with the largest entry in column `k`.
std::size_t pivot_row(const Matrix& a, std::size_t k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < a.size(); ++i) {
        if (std::abs(a(i, k)) > std::abs(a(pivot, k))) pivot = i;
    }
    return pivot;
}

/// a^-1 b, by elimination with the largest pivot.
Matrix solve(Matrix a, Matrix b) {
    const std::size_t n = a.size();
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t pivot = pivot_row(a, k);
        for (std::size_t j = 0; j < n; ++j) {
            std::swap(a(k, j), a(pivot, j));
            std::swap(b(k, j), b(pivot, j));
        }
        for (std::size_t i = 0; i < n; ++i) {
            if (i == k) continue;
            const double factor = a(i, k) / a(k, k);
            for (std::size_t j = k; j < n; ++j)
                a(i, j) -= factor * a(k, j);
            for (std::size_t j = 0; j < n; ++j)
                b(i, j) -= factor * b(k, j);
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j)
            b(i, j) /= a(i, i);
    }
    return b;
}

double legendre(int l, double x) {
    double before = 1;
    double here = x;
    if (l == 0) return 1;
    for (int k = 2; k <= l; ++k) {
        const double next = ((2 * k - 1) * x * here - (k - 1) * before) / k;
        before = here;
        here = next;
    }
    return here;
}

struct Quadrature {
    std::vector<double> mu, weight;
};

/// Radau's rule from `low` to `high` with a point at `high`: the others are the roots of (P_{n-1} - P_n) / (1 - x),
/// found by bisection between sign changes. `with_end` false: Gauss' rule.
void add_rule(Quadrature& q, int n, double low, double high, bool with_end) {
    const auto f = [&](double x) {
        return with_end ? (legendre(n - 1, x) - legendre(n, x)) / (1 - x) : legendre(n, x);
    };
    const int steps = 40 * n * n;
    const auto x_of = [&](int i) { return -std::cos(3.14159265358979323846 * (i + 0.5) / (steps + 1)); };
    const auto add = [&](double x, double weight) {
        q.mu.push_back(low + 0.5 * (high - low) * (1 + x));
        q.weight.push_back(0.5 * (high - low) * weight);
    };
    for (int i = 0; i < steps; ++i) {
        double a = x_of(i);
        double b = x_of(i + 1);
        if (f(a) * f(b) > 0) continue;
        for (int k = 0; k < 60; ++k) {
            const double middle = 0.5 * (a + b);
            (f(a) * f(middle) <= 0 ? b : a) = middle;
        }
        const double x = 0.5 * (a + b);
        const double p = legendre(n - 1, x);
        // Both follow from the Christoffel-Darboux sum; Radau's is for the rule with an end at 1.
        add(x, with_end ? (1 + x) / (n * n * p * p) : 2 * (1 - x * x) / (n * n * p * p));
    }
    if (with_end) add(1, 2.0 / (n * n));
}

/// What a stack of layers does to intensities that come from above and from below.
struct Stack {
    Matrix r_above, t_down, r_below, t_up;
};

Stack add(const Stack& a, const Stack& b) {
    const Matrix one(a.t_down.size(), 1);
    const Matrix down = solve(sum(one, -1, a.r_below * b.r_above), a.t_down);
    const Matrix up = solve(sum(one, -1, b.r_above * a.r_below), b.t_up);
    return {sum(a.r_above, 1, a.t_up * (b.r_above * down)), b.t_down * down,
            sum(b.r_below, 1, b.t_down * (a.r_below * up)), a.t_up * up};
}

/// One layer: a very thin one by the diamond rule, doubled. The peak of the phase function beyond the quadrature is
/// taken for light that goes on straight (delta-M; Wiscombe, J. Atmos. Sci. 34 (1977) 1408).
Stack layer_of(const PlaneLayer& layer, const Quadrature& q) {
    const std::size_t n = q.mu.size();
    const int terms = static_cast<int>(n) / 2 - 2;
    const double peak = std::pow(layer.g, terms);
    const double albedo = layer.albedo * (1 - peak) / (1 - layer.albedo * peak);
    double depth = layer.thickness * (1 - layer.albedo * peak);
    int doublings = 0;
    for (; depth > 2e-5; depth *= 0.5)
        ++doublings;
    Matrix alpha(n, 0);
    Matrix beta(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
            double ahead = 0;
            double back = 0;
            for (int l = 0; l < terms; ++l) {
                const double moment = (std::pow(layer.g, l) - peak) / (1 - peak);
                const double term = (2 * l + 1) * moment * legendre(l, q.mu[i]) * legendre(l, q.mu[j]);
                ahead += term;
                back += l % 2 == 0 ? term : -term;
            }
            const double scale = 0.5 * depth / q.mu[i];
            alpha(i, j) = scale * ((i == j ? 1 : 0) - 0.5 * albedo * ahead * q.weight[j]);
            beta(i, j) = scale * 0.5 * albedo * back * q.weight[j];
        }
    }
    const Matrix one(n, 1);
    const Matrix whole = sum(one, 1, alpha);
    const Matrix gamma = beta * solve(whole, beta);
    const Matrix t = solve(sum(whole, -1, gamma), sum(sum(one, -1, alpha), 1, gamma));
    const Matrix r = solve(whole, beta * sum(one, 1, t));
    Stack stack{r, t, r, t};
    for (int i = 0; i < doublings; ++i)
        stack = add(stack, stack);
    return stack;
}

/// Fresnel's reflectance for a cosine on side 1.
double fresnel(double n1, double n2, double cosine) {
    const double sine = n1 / n2 * std::sqrt(1 - cosine * cosine);
    if (sine >= 1) return 1;
    const double other = std::sqrt(1 - sine * sine);
    const double s = (n1 * cosine - n2 * other) / (n1 * cosine + n2 * other);
    const double p = (n1 * other - n2 * cosine) / (n1 * other + n2 * cosine);
    return 0.5 * (s * s + p * p);
}

/// Of the sheet of glass seen from inside the sample: all passes through it, incoherent.
double glass_reflectance(double index, double glass, double cosine) {
    const double first = fresnel(index, glass, cosine);
    const double sine = index / glass * std::sqrt(1 - cosine * cosine);
    if (sine >= 1) return 1;
    const double second = fresnel(glass, 1, std::sqrt(1 - sine * sine));
    if (first >= 1 || second >= 1) return 1;
    return (first + second - 2 * first * second) / (1 - first * second);
}

}  // namespace

PlaneFluxes adding_doubling(const std::vector<PlaneLayer>& layers, double index, double glass, int points) {
    Quadrature q;
    const double critical = std::sqrt(1 - 1 / (index * index));
    if (critical > 0) add_rule(q, points / 2, 0, critical, false);
    add_rule(q, critical > 0 ? points / 2 : points, critical, 1, true);
    const std::size_t n = q.mu.size();

    Stack stack = layer_of(layers[0], q);
    for (std::size_t i = 1; i < layers.size(); ++i)
        stack = add(stack, layer_of(layers[i], q));
    Matrix face(n, 0);
    for (std::size_t i = 0; i < n; ++i)
        face(i, i) = glass_reflectance(index, glass, q.mu[i]);
    const Matrix one(n, 1);
    const Stack back{face, sum(one, -1, face), face, sum(one, -1, face)};
    const Stack rest = add(stack, back);

    PlaneFluxes fluxes;
    fluxes.specular = face(n - 1, n - 1);
    Matrix light(n, 0);  // its first column
    light(n - 1, 0) = (1 - fluxes.specular) / (2 * q.mu[n - 1] * q.weight[n - 1]);
    // Downward just under the upper face, which sends back what comes from below.
    const Matrix down = solve(sum(one, -1, face * rest.r_above), light);
    const Matrix up = rest.r_above * down;
    const Matrix out = rest.t_down * down;
    for (std::size_t i = 0; i < n; ++i) {
        fluxes.reflected += 2 * q.mu[i] * q.weight[i] * (1 - face(i, i)) * up(i, 0);
        fluxes.transmitted += 2 * q.mu[i] * q.weight[i] * out(i, 0);
    }
    return fluxes;
}

}  // namespace fluovox::reference
