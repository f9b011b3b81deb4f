#include "fluovox/volume/grid_integral.h"

#include "fluovox/volume/bound_visitor.h"

namespace fluovox {

// All it calls lies in one function, as for trackings.
[[gnu::flatten]] void GridIntegral::add(const SparseGrid& grid, const Ray& ray) {
    cell_.low = kNone;
    constexpr double kFinest = 1e30;  // as a coefficient: cells where there is nothing are passed
    BoundVisitor(grid, ray, {0, std::numeric_limits<double>::infinity()}, kFinest).run(*this);
}

double integral_along(const SparseGrid& grid, const Ray& ray) {
    GridIntegral integral(std::numeric_limits<double>::infinity());
    integral.add(grid, ray);
    return integral.total();
}

}  // namespace fluovox
