#pragma once

// Internal: the block of metadata that ImageJ keeps in a TIFF's first directory (tags 50838 and 50839). Not installed.

#include "fluovox/image/stack_info.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// What stands for black and for full brightness at first sight, in the units of the stored samples.
struct DisplayRange {
    double low = 0, high = 1;
};

/// Finds a range for each channel of a stack from all its values, page by page.
class DisplayRanges {
public:
    explicit DisplayRanges(const StackInfo& info);

    void add(int channel, std::span<const float> values);
    /// Of labels (StackInfo::quantity "labels"): 0 to the largest. Otherwise from the smallest value (0 where that is
    /// below) to the one that a thousandth of the lit pixels lie above, so that a few bright ones do not darken the
    /// rest. 0 to 1 where there is no light.
    DisplayRange range(int channel) const;

private:
    struct Seen {
        float least = 0, most = 0;
        bool any = false;
        std::vector<std::uint64_t> lit;  ///< positive values, counted by their leading bits
    };

    double value_per_count_;
    bool labels_;
    std::vector<Seen> channels_;
};

/// The two tags' values: sizes of the parts, and the parts.
struct ImageJMetadata {
    std::vector<std::uint32_t> sizes;
    std::string bytes;
};

/// In little-endian order: our description of the stack as ImageJ's "Info", the channels' names as labels of the
/// images, and (for several channels) their ranges and colours.
ImageJMetadata imagej_metadata(const StackInfo& info, const std::vector<DisplayRange>& ranges);

/// Our own description (`to_json`) and the scene, out of tag 50839's bytes in either order; empty where it has none.
struct ImageJInfo {
    std::string stack_json, scene_json;
};
ImageJInfo imagej_info_in(std::string_view metadata, std::span<const std::uint32_t> sizes);

}  // namespace fluovox
