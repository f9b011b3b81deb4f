#include "fluovox/core/progress.h"

#include "command.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <string>

namespace fluovox::tools {
namespace {

// Threads ask for it, so it is more than a sig_atomic_t; without a lock a signal may set it.
std::atomic<bool> stop_requested = false;  // NOLINT(*-avoid-non-const-global-variables): a signal's only channel
static_assert(std::atomic<bool>::is_always_lock_free);

void request_stop(int signal) {
    stop_requested = true;
    std::signal(signal, SIG_DFL);  // a second one ends the program at once
}

class Silent final : public Progress {
public:
    void start(const char* /*stage*/, long long /*units*/) override {}
    void advance(long long /*units*/) override {}
    bool stopped() const override { return stop_requested; }
};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Redraws one line of a terminal a few times a second, or prints a plain line every tenth of the work.
class Shown final : public Progress {
public:
    explicit Shown(bool bar) : bar_(bar) {}
    Shown(const Shown&) = delete;
    Shown& operator=(const Shown&) = delete;
    ~Shown() override { finish_line(); }

    void start(const char* stage, long long units) override {
        const std::lock_guard lock(mutex_);
        finish_line();
        stage_ = stage;
        units_ = units;
        done_ = 0;
        next_ = bar_ ? 0 : 0.1;
        begin_ = Clock::now();
    }
    void advance(long long units) override {
        const long long done = done_ += units;
        if (units_ <= 0) return;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock.owns_lock()) show(static_cast<double>(done) / static_cast<double>(units_));
    }
    bool stopped() const override { return stop_requested; }

private:
    void show(double share) {
        const double elapsed = seconds_since(begin_);
        const double now = bar_ ? elapsed : share;
        if (now < next_ && share < 1) return;
        next_ = bar_ ? elapsed + 0.2 : share + 0.1;
        const double left = share > 0 ? elapsed * (1 - share) / share : 0;
        if (!bar_) {
            std::fprintf(stderr, "%s: %3.0f %%, %.0f s left\n", stage_.c_str(), 100 * share, left);
            return;
        }
        constexpr int kWidth = 30;
        const int filled = static_cast<int>(share * kWidth);
        std::fprintf(stderr, "\r%-12s [%-*s] %3.0f %%  %.0f s left  ", stage_.c_str(), kWidth,
                     std::string(static_cast<std::size_t>(filled), '=').c_str(), 100 * share, left);
        line_open_ = true;
    }
    void finish_line() {
        if (line_open_) std::fputc('\n', stderr);
        line_open_ = false;
    }

    bool bar_;
    bool line_open_ = false;
    std::string stage_;
    long long units_ = 0;
    std::atomic<long long> done_ = 0;
    double next_ = 0;
    Clock::time_point begin_ = Clock::now();
    std::mutex mutex_;
};

}  // namespace

std::unique_ptr<Progress> make_progress(const CommonOptions& common) {
    std::signal(SIGINT, request_stop);
    std::signal(SIGTERM, request_stop);
    const bool terminal = ::isatty(STDERR_FILENO) != 0;
    if (common.quiet || common.progress == "none") return std::make_unique<Silent>();
    if (common.progress == "auto" && !terminal) return std::make_unique<Silent>();
    return std::make_unique<Shown>(common.progress != "plain" && (terminal || common.progress == "bar"));
}

}  // namespace fluovox::tools
