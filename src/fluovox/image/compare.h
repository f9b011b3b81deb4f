#pragma once

#include "fluovox/image/png.h"
#include "fluovox/image/rendered_image.h"

#include <cstddef>
#include <string>
#include <vector>

namespace fluovox {

/// What `compare` found.
struct Comparison {
    bool same = true;           ///< no difference beyond noise, at the level asked for
    double p_value = 1;         ///< of the whole comparison: the chance of a difference this large between equal scenes
    std::size_t pixels = 0;     ///< compared
    std::size_t differing = 0;  ///< pixels that differ on their own, at the level of the whole
    double mean_a = 0;          ///< of all light over pixels and channels
    double mean_b = 0;
    std::string where;             ///< of the smallest p-value: "pixel (3, 7), fluorescence 550,000nm"; or "nowhere"
    double z_limit = 0;            ///< |z| of one pixel and channel beyond which it counts as differing
    std::vector<float> strongest;  ///< for each pixel the z of largest size over layers and channels; positive: b > a
};

/// Are two renders the same within their noise? Pixels, tiles of 8 x 8 pixels and the whole image are tested, each for
/// every layer (elastic and fluorescence apart, and each dye), in each channel and all channels together. The renders
/// must not share random numbers; where they do the test is only less sensitive.
///
/// The test must hold for pixels whose samples are far from Gaussian (64 samples, most of them zero, some a hundred
/// times the mean), where an ordinary t-test fires far too often. So:
///
/// - z = |sum d| / sqrt(sum e) over the pixels of a region, with d = b - a, and e = (v nu + d^2) / (nu + 1) of each
/// pixel,
///   v = v_a + v_b the variances of the means, nu the degrees of freedom (Welch, Biometrika 34, 1947, 28). Under
///   exchange of samples between two equal renders, e is the expected square of d, so z is a self-normalised sum of
///   signs, for which P(z > x) <= 2 exp(-x^2 / 2) whatever the distribution (Hoeffding, JASA 58, 1963, 13; Efron, JASA
///   64, 1969, 1278). That bound is the p-value; against Gaussian tails it gives up half a standard error.
/// - A render that missed its rare bright samples is dark and seems sure of it. Its variance is raised in proportion to
///   the other's mean (variance of counts), and for equal estimators with different counts at least to the pooled
///   sample variance. Where the estimators or their noise (by more than a factor 2) differ, one may be much noisier
///   than its samples show: there a pixel or tile has at least the variance per brightness of the pixels around it and
///   of the image, and tiles and image are judged by Student's t with as many degrees of freedom as pixels carry the
///   noise. This costs sensitivity in dark parts, and it is a safeguard, not a guarantee: nobody can know of noise that
///   an estimator has hardly shown anywhere.
///   A channel that a render has not seen at all is taken to be as noisy as the noisiest of its layer.
/// - Photons that reach several pixels, and passes that all pixels share, make noise that is not independent: such
///   images (RenderedImage::shares_samples) bring the variances of their tiles and of the whole, which are used there.
/// - Relative differences below 2e-6 are rounding, never a difference.
/// - The smallest p is multiplied by the number of tests (Bonferroni), with equal shares for the three sizes of region.
///
/// Pixels of one sample tell their spread by the differences alone. `significance` is the chance of
/// "different" for equal scenes, at most. Throws InputError if sizes, layers, channels or units differ.
Comparison compare(const RenderedImage& a, const RenderedImage& b, double significance = 1e-3);

/// The z of each pixel: blue where b is darker, red where it is brighter, white for no difference; full colour is
/// `z_limit`.
Picture difference_picture(const Comparison& comparison, int width, int height);

/// The p-value of each pixel on its own: white for 1, darker for smaller, black at the limit, red beyond.
Picture p_value_picture(const Comparison& comparison, int width, int height);

}  // namespace fluovox
