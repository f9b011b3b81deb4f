#pragma once

#include "fluovox/core/file_lock.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace fluovox {

/// What is known of one finished plane besides its pixels.
struct PlaneFigures {
    std::optional<double> median_relative_error;  ///< over the pixels that have light; nothing: not known
    std::optional<double> bright_relative_error;  ///< median over the brightest tenth of those pixels
    double max_value = 0;
    std::optional<double> seconds;  ///< that it took; nothing: not recorded
    std::int64_t nan_count = 0;
    std::int64_t bound_violations = 0;
    bool is_dark = false;
};

/// A folder of finished planes beside the result they will become: what was done before work was stopped is kept
/// there. Every file appears whole or not at all. It belongs to one run at a time.
class PlaneStore {
public:
    /// Opens or makes `folder`. `key` is the same for the same work. Throws UsageError where the folder holds planes of
    /// other work, unless `overwrite`; OutputError where it cannot be written, and while another run has it.
    PlaneStore(const std::filesystem::path& folder, const std::string& key, std::size_t values_per_plane,
               bool overwrite);

    const std::filesystem::path& folder() const { return folder_; }
    bool has(int plane) const;
    void save(int plane, std::span<const float> values, const PlaneFigures& figures) const;
    PlaneFigures figures(int plane) const;
    /// Values from `first` on. Throws InputError where the file is damaged.
    void load(int plane, std::size_t first, std::span<float> values) const;
    /// Removes the folder.
    void remove() const;
    /// Bytes of one plane's file, to within a kilobyte.
    double plane_bytes() const;

private:
    std::filesystem::path file_of(int plane) const;

    std::filesystem::path folder_;
    FileLock lock_;
    std::size_t values_per_plane_;
};

}  // namespace fluovox
