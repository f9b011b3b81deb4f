#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox::bench {

/// The one table of the bench, printed row by row as its figures come in.
class Table {
public:
    Table();

    void heading(const std::string& text);
    /// A figure without a target.
    void figure(const std::string& measure, double value);
    /// Figures with a target: met when the value is at least, or at most, that.
    void at_least(const std::string& measure, double value, double target);
    void at_most(const std::string& measure, double value, double target);

    /// Prints how many targets are met; false when one is missed.
    bool finish() const;
    void save_json(const std::filesystem::path& file) const;

private:
    struct Row {
        std::string heading, measure;
        double value = 0;
        std::optional<double> target;
        bool met = true;
    };
    void add(Row row, const std::string& relation);

    std::string heading_;
    std::vector<Row> rows_;
};

}  // namespace fluovox::bench
