#include "table.h"

#include "fluovox/core/atomic_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace fluovox::bench {

Table::Table() {
    fmt::print("{:<74} {:>10} {:>10}  {}\n", "measure", "figure", "target", "met");
}

void Table::heading(const std::string& text) {
    heading_ = text;
    fmt::print("\n{}\n", text);
}

void Table::add(Row row, const std::string& relation) {
    row.heading = heading_;
    const std::string target = row.target ? fmt::format("{} {:.4g}", relation, *row.target) : "";
    fmt::print("  {:<72} {:>10.3g} {:>10}  {}\n", row.measure, row.value, target,
               !row.target ? "" : (row.met ? "yes" : "NO"));
    std::fflush(stdout);
    rows_.push_back(std::move(row));
}

void Table::figure(const std::string& measure, double value) {
    add({{}, measure, value, {}, true}, "");
}

void Table::at_least(const std::string& measure, double value, double target) {
    add({{}, measure, value, target, value >= target}, ">=");
}

void Table::at_most(const std::string& measure, double value, double target) {
    add({{}, measure, value, target, value <= target}, "<=");
}

bool Table::finish() const {
    const auto targets =
        std::count_if(rows_.begin(), rows_.end(), [](const Row& row) { return row.target.has_value(); });
    const auto missed = std::count_if(rows_.begin(), rows_.end(), [](const Row& row) { return !row.met; });
    fmt::print("\n{} of {} targets met\n", targets - missed, targets);
    return missed == 0;
}

void Table::save_json(const std::filesystem::path& file) const {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const Row& row : rows_) {
        nlohmann::ordered_json one = {{"group", row.heading}, {"measure", row.measure}, {"figure", row.value}};
        if (row.target) {
            one["target"] = *row.target;
            one["met"] = row.met;
        }
        all.push_back(std::move(one));
    }
    write_text_file(file, nlohmann::ordered_json{{"rows", all}}.dump(2) + '\n');
}

}  // namespace fluovox::bench
