#include "fluovox/transport/film_response.h"

#include "fluovox/spectral/photons.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

using Ranges = std::vector<std::pair<double, double>>;

bool in_some_band(const FilterDescription& filter, double wavelength_nm) {
    return std::any_of(filter.bands.begin(), filter.bands.end(),
                       [&](const auto& band) { return wavelength_nm >= band.from_nm && wavelength_nm <= band.to_nm; });
}

// Where a channel begins and ends, and where the filter's bands do within it.
std::vector<double> edges_of(const FilmChannel& channel, const std::optional<FilterDescription>& filter) {
    std::vector<double> edges = {channel.response.first_nm(), channel.response.last_nm()};
    if (!filter) return edges;
    for (const auto& band : filter->bands) {
        for (const double edge : {band.from_nm, band.to_nm}) {
            if (edge > edges.front() && edge < edges.back()) edges.insert(edges.end() - 1, edge);
        }
    }
    std::sort(edges.begin(), edges.end());
    return edges;
}

// The ranges of the channels, cut where the filter begins or ends, without the pieces that it blocks.
Ranges ranges_seen(const std::vector<FilmChannel>& channels, const std::optional<FilterDescription>& filter) {
    Ranges ranges;
    for (const FilmChannel& channel : channels) {
        const std::vector<double> edges = edges_of(channel, filter);
        for (std::size_t i = 1; i < edges.size(); ++i) {
            const double middle = 0.5 * (edges[i - 1] + edges[i]);
            if (!filter || in_some_band(*filter, middle) == filter->passes) ranges.emplace_back(edges[i - 1], edges[i]);
        }
    }
    return ranges;
}

constexpr double kEdge_nm = 1e-6;

// All that is seen, from short to long, as few ranges as possible.
Ranges where_seen(const FilmSpec& spec, const std::optional<FilterDescription>& filter) {
    Ranges ranges = ranges_seen(spec.channels, filter);
    if (ranges.empty()) ranges = ranges_seen(spec.channels, std::nullopt);  // dark, but still a density
    std::sort(ranges.begin(), ranges.end());
    Ranges merged;
    for (const auto& [from, to] : ranges) {
        if (!merged.empty() && from <= merged.back().second + kEdge_nm) {
            merged.back().second = std::max(merged.back().second, to);
        } else {
            merged.emplace_back(from, to);
        }
    }
    return merged;
}

// One in the ranges, zero between them.
Spectrum one_in(const Ranges& ranges) {
    std::vector<double> knots;
    std::vector<double> values;
    for (const auto& [from, to] : ranges) {
        if (!knots.empty()) {  // the gap: down and up again within an edge
            knots.insert(knots.end(), {knots.back() + 0.25 * kEdge_nm, from - 0.25 * kEdge_nm});
            values.insert(values.end(), {0, 0});
        }
        knots.insert(knots.end(), {from, to});
        values.insert(values.end(), {1, 1});
    }
    return {std::move(knots), std::move(values)};
}

// Each bin of a spectrum has its own on every path where they are few; a channel averages over few.
int lanes_for(const FilmSpec& spec) {
    constexpr int kFew = 8;
    return spec.is_spectral ? std::clamp(static_cast<int>(spec.channels.size()), kFew, kMaxLanes) : kFew;
}

}  // namespace

FilmResponse::FilmResponse(const FilmSpec& spec, const std::optional<FilterDescription>& filter)
    : spec_(&spec),
      filter_(filter),
      ranges_(where_seen(spec, filter)),
      where_(one_in(ranges_)),
      lanes_(lanes_for(spec)) {
    for (const auto& [from, to] : ranges_)
        total_nm_ += to - from;
}

Wavelengths FilmResponse::sample(double u) const {
    return comb(u, lanes_);
}

Wavelengths FilmResponse::sample_one(double u) const {
    return comb(u, 1);
}

Wavelengths FilmResponse::comb(double u, int count) const {
    Wavelengths wavelengths(count);
    for (int k = 0; k < count; ++k) {
        double place = u + static_cast<double>(k) / count;
        place = (place < 1 ? place : place - 1) * total_nm_;
        std::size_t i = 0;
        for (; i + 1 < ranges_.size() && place >= ranges_[i].second - ranges_[i].first; ++i)
            place -= ranges_[i].second - ranges_[i].first;
        wavelengths.nm[k] = std::min(ranges_[i].first + place, ranges_[i].second);
        wavelengths.pdf_per_nm[k] = 1 / total_nm_;
    }
    return wavelengths;
}

bool FilmResponse::passes(double wavelength_nm) const {
    if (!filter_) return true;
    return in_some_band(*filter_, wavelength_nm) == filter_->passes;
}

bool FilmResponse::sees(double wavelength_nm) const {
    if (!passes(wavelength_nm)) return false;
    return std::any_of(spec_->channels.begin(), spec_->channels.end(),
                       [&](const FilmChannel& channel) { return channel.response(wavelength_nm) > 0; });
}

bool FilmResponse::sees(const LightSpectrum& light) const {
    const auto& knots = light.energy_per_nm.wavelengths_nm();
    return std::any_of(light.lines.begin(), light.lines.end(),
                       [&](const auto& line) { return sees(line.wavelength_nm); }) ||
           std::any_of(knots.begin(), knots.end(), [&](double nm) { return sees(nm); });
}

Spectrum FilmResponse::seen_part(const Spectrum& spectrum) const {
    return sampling_product(spectrum, where_);
}

void FilmResponse::add(const Wavelengths& wavelengths, const Lanes& per_nm, std::span<double> values) const {
    if (per_nm.sum() == 0) return;
    const int count = wavelengths.count();
    for (int k = 0; k < count; ++k)
        add(wavelengths.nm[k], per_nm[k] / (count * wavelengths.pdf_per_nm[k]), values);
}

void FilmResponse::add(double wavelength_nm, double photons, std::span<double> values) const {
    constexpr double um2_per_m2 = 1e12;
    if (photons == 0 || !passes(wavelength_nm)) return;
    const double per_m2 = photons * um2_per_m2;
    const double watts = per_m2 * photon_energy_J(wavelength_nm);
    const auto& channels = spec_->channels;
    if (spec_->is_spectral) {  // bins of equal width: each wavelength is in one
        const double width = (spec_->to_nm - spec_->from_nm) / static_cast<double>(channels.size());
        const double bin = (wavelength_nm - spec_->from_nm) / width;
        if (!(bin >= 0) || bin >= static_cast<double>(channels.size())) return;
        values[static_cast<std::size_t>(bin)] += (spec_->unit == FilmUnit::Photons ? per_m2 : watts) / width;
        return;
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const bool counts = spec_->unit == FilmUnit::Photons || channels[c].counts_photons;
        values[c] += channels[c].response(wavelength_nm) * (counts ? per_m2 : watts);
    }
}

}  // namespace fluovox
