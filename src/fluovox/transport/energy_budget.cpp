#include "fluovox/transport/energy_budget.h"

namespace fluovox {

void BudgetLayout::complete(double* row) const {
    double total = row[kCut];
    for (std::size_t m = 0; m < media_; ++m)
        total += row[absorbed(m)];
    for (int e = 0; e < LightBudget::kEscapes; ++e) {
        double& all = row[escaped(LightBudget::kAll, e)];
        all = 0;
        for (int f = 0; f < LightBudget::kFaces; ++f)
            all += row[escaped(f, e)];
        total += all;
    }
    for (int f = 0; f <= LightBudget::kFaces; ++f)
        row[not_specular(f)] = row[escaped(f, 1)] + row[escaped(f, 2)];
    row[kTotal] = total;
}

LightBudget BudgetLayout::budget(const Estimate* row) const {
    LightBudget budget;
    budget.launched = row[kLaunched];
    budget.cut = row[kCut];
    budget.total = row[kTotal];
    for (std::size_t m = 0; m < media_; ++m)
        budget.absorbed.push_back(row[absorbed(m)]);
    for (int f = 0; f <= LightBudget::kFaces; ++f) {
        budget.not_specular[static_cast<std::size_t>(f)] = row[not_specular(f)];
        for (int e = 0; e < LightBudget::kEscapes; ++e) {
            const auto face = static_cast<std::size_t>(f);
            const auto escape = static_cast<std::size_t>(e);
            budget.escaped[face][escape] = row[escaped(f, e)];
            if (f == LightBudget::kFaces) continue;
            for (std::size_t bin = 0; bin < bins_; ++bin)
                budget.by_angle[face][escape].push_back(row[angle(f, e, bin)]);
        }
    }
    for (std::size_t d = 0; d < dyes_; ++d) {
        budget.reemitted.push_back(row[reemitted(d)]);
        budget.yield_loss.push_back(row[yield_loss(d)]);
        budget.not_followed.push_back(row[not_followed(d)]);
    }
    return budget;
}

}  // namespace fluovox
