#pragma once

namespace fluovox {

/// Where long work reports how far it is. The program shows it on a terminal; a test ignores it.
/// Called from many threads at once.
class Progress {
public:
    Progress() = default;
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    virtual ~Progress() = default;

    /// A new stage of the work begins: what it is called and how many units it has.
    virtual void start(const char* stage, long long units) = 0;
    /// `units` more of the stage are done.
    virtual void advance(long long units) = 0;
    /// True once the user asked to stop; long loops look at it and return early.
    virtual bool stopped() const = 0;
};

/// Shows nothing and never stops.
class NoProgress final : public Progress {
public:
    void start(const char* /*stage*/, long long /*units*/) override {}
    void advance(long long /*units*/) override {}
    bool stopped() const override { return false; }
};

}  // namespace fluovox
