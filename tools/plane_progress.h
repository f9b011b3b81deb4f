#pragma once

#include "fluovox/core/progress.h"

#include <algorithm>
#include <atomic>

namespace fluovox::tools {

/// Shows the planes of a stack as one piece of work.
class PlaneProgress final : public Progress {
public:
    static constexpr long long kUnits = 1000;  // of one plane

    explicit PlaneProgress(Progress& whole) : whole_(&whole) {}
    void start(const char* /*stage*/, long long units) override {
        units_ = std::max(units, 1LL);
        done_ = 0;
        shown_ = 0;
    }
    void advance(long long units) override {
        const long long now = (done_ += units) * kUnits / units_;
        const long long before = shown_.exchange(now);
        if (now > before) whole_->advance(now - before);
    }
    bool stopped() const override { return whole_->stopped(); }

private:
    Progress* whole_;
    long long units_ = 1;
    std::atomic<long long> done_ = 0, shown_ = 0;
};

}  // namespace fluovox::tools
