#include "fluovox/core/error.h"
#include "fluovox/voxelize/mesh_readers.h"
#include "fluovox/voxelize/morphology_internal.h"

#include <cctype>
#include <optional>

namespace fluovox {
namespace {

/// The pieces of a Neurolucida file: brackets, bars, texts and words.
class AscTokens {
public:
    AscTokens(std::string_view text, std::string name) : text_(text), name_(std::move(name)) { next(); }

    /// The current token; empty at the end.
    std::string_view token() const { return token_; }
    bool is(char symbol) const { return token_.size() == 1 && token_[0] == symbol; }
    void next() {
        skip_blanks();
        if (at_ >= text_.size()) {
            token_ = {};
            return;
        }
        const std::size_t begin = at_++;
        constexpr std::string_view kSymbols = "()|<>,";
        if (text_[begin] == '"') {
            while (at_ < text_.size() && text_[at_] != '"')
                ++at_;
            if (at_ < text_.size()) ++at_;
        } else if (kSymbols.find(text_[begin]) == std::string_view::npos) {
            while (at_ < text_.size() && kSymbols.find(text_[at_]) == std::string_view::npos &&
                   std::isspace(static_cast<unsigned char>(text_[at_])) == 0 && text_[at_] != ';')
                ++at_;
        }
        token_ = text_.substr(begin, at_ - begin);
    }
    bool at_number() const {
        if (token_.empty()) return false;
        const char c = token_[0];
        return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '+' || c == '.';
    }
    double number() {
        const TextScanner where({}, name_ + ':' + std::to_string(line_));
        const double value = to_number(token_, where);
        next();
        return value;
    }
    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(name_ + ':' + std::to_string(line_) + ": " + message);
    }

private:
    void skip_blanks() {
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == '\n') ++line_;
            if (c == ';') {
                while (at_ < text_.size() && text_[at_] != '\n')
                    ++at_;
            } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
                ++at_;
            } else {
                return;
            }
        }
    }

    std::string_view text_;
    std::string name_;
    std::size_t at_ = 0;
    long long line_ = 1;
    std::string_view token_;
};

class AscReader {
public:
    AscReader(std::string_view text, const std::string& name) : in_(text, name) {}

    MorphologyTree run() {
        if (!in_.is('(')) in_.fail("is not a Neurolucida ASC file (it begins with a bracket)");
        while (!in_.token().empty()) {
            if (in_.is('(')) {
                in_.next();
                block();
            } else {
                in_.next();
            }
        }
        return std::move(tree_);
    }

private:
    /// A block at the top level: a tree, a contour, or something else. Its opening bracket is read.
    void block() {
        int type = 0;
        bool soma = false;
        std::vector<Vec3> contour;
        std::uint32_t parent = kNoParent;
        while (!in_.is(')')) {
            if (in_.token().empty()) in_.fail("is truncated: a bracket has no end");
            if (in_.is('<')) {
                spine(parent);
            } else if (in_.is('(')) {
                in_.next();
                if (in_.at_number()) {
                    const TracedPoint point = point_after_bracket(type);
                    if (soma) {
                        contour.push_back(point.position);
                    } else if (type != 0) {
                        parent = add(point, parent);
                    }
                } else if (const auto kind = kind_of(in_.token())) {
                    type = *kind;
                    soma |= type == kSomaType;
                    skip_list(1);
                } else if (in_.is('(') || in_.is('|')) {
                    split(parent, type, 1);
                } else {
                    skip_list(1);  // colour, name, properties
                }
            } else {
                in_.next();
            }
        }
        in_.next();
        if (contour.size() >= 3) tree_.soma_contours.push_back(std::move(contour));
    }

    /// Branches between brackets, apart by bars; the opening bracket is read.
    void split(std::uint32_t parent, int type, int depth) {
        constexpr int kDeepest = 5000;
        if (depth > kDeepest) in_.fail("its branches are nested too deeply");
        std::uint32_t last = parent;
        while (!in_.is(')')) {
            if (in_.token().empty()) in_.fail("is truncated: a branch has no end");
            if (in_.is('|')) {
                last = parent;
                in_.next();
            } else if (in_.is('<')) {
                spine(last);
            } else if (in_.is('(')) {
                in_.next();
                if (in_.at_number()) {
                    const TracedPoint point = point_after_bracket(type);
                    if (type != 0) last = add(point, last);
                } else if (in_.is('(') || in_.is('|')) {
                    split(last, type, depth + 1);
                } else {
                    skip_list(1);
                }
            } else {
                in_.next();  // how the branch ends: Normal, High, Incomplete ...
            }
        }
        in_.next();
    }

    /// `< (x y z d) >`: a spine from the current point to that one.
    void spine(std::uint32_t parent) {
        in_.next();
        while (!in_.is('>')) {
            if (in_.token().empty()) in_.fail("is truncated: a spine has no end");
            if (!in_.is('(')) {
                in_.next();
                continue;
            }
            in_.next();
            if (!in_.at_number()) {
                skip_list(1);
                continue;
            }
            const TracedPoint tip = point_after_bracket(0);
            if (parent == kNoParent || !(tip.radius > 0)) continue;
            tree_.spines.push_back({tree_.points[parent].position, tip.position, tip.radius, tip.radius});
        }
        in_.next();
    }

    /// Numbers up to the closing bracket: x, y, z, diameter.
    TracedPoint point_after_bracket(int type) {
        TracedPoint point;
        point.type = type;
        for (int axis = 0; axis < 3; ++axis)
            point.position[axis] = in_.at_number() ? in_.number() : 0;
        if (in_.at_number()) point.radius = in_.number() / 2;
        skip_list(1);
        return point;
    }
    /// Up to the bracket that closes the list we are in.
    void skip_list(int depth) {
        while (depth > 0) {
            if (in_.token().empty()) in_.fail("is truncated: a bracket has no end");
            if (in_.is('(')) ++depth;
            if (in_.is(')')) --depth;
            in_.next();
        }
    }
    std::uint32_t add(TracedPoint point, std::uint32_t parent) {
        point.parent = parent;
        tree_.points.push_back(point);
        return static_cast<std::uint32_t>(tree_.points.size() - 1);
    }
    static std::optional<int> kind_of(std::string_view word) {
        if (word == "CellBody") return kSomaType;
        if (word == "Axon") return 2;
        if (word == "Dendrite") return 3;
        if (word == "Apical") return 4;
        return {};
    }

    AscTokens in_;
    MorphologyTree tree_;
};

}  // namespace

MorphologyTree parse_asc(std::string_view bytes, const std::string& name) {
    return AscReader(bytes, name).run();
}

}  // namespace fluovox
