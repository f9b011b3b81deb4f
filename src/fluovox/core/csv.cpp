#include "fluovox/core/csv.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

struct Cell {
    std::string_view text;
    int column;  // from 1
};

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kSpace = " \t\r";
    const auto first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos) return {};
    text = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
    return text;
}

std::vector<Cell> split(std::string_view line, char separator) {
    std::vector<Cell> cells;
    std::size_t begin = 0;
    while (true) {
        const std::size_t end = std::min(line.find(separator, begin), line.size());
        const std::string_view cell = line.substr(begin, end - begin);
        const std::size_t indent = std::min(cell.find_first_not_of(" \t"), cell.size());
        cells.push_back({trimmed(cell), static_cast<int>(begin + indent) + 1});
        if (end == line.size()) return cells;
        begin = end + 1;
    }
}

char separator_of(std::string_view line) {
    for (const char candidate : {',', ';', '\t'}) {
        if (line.find(candidate) != std::string_view::npos) return candidate;
    }
    return ',';
}

std::optional<double> number(std::string_view text) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc{} || end != text.data() + text.size()) return {};
    return value;
}

// A cell as it may be shown in a message: short, and without bytes that upset a terminal.
std::string shown(std::string_view text) {
    std::string result;
    for (const char c : text.substr(0, 40))
        result += c >= ' ' && c <= '~' ? c : '?';
    return text.size() > 40 ? result + "..." : result;
}

class Parser {
public:
    Parser(const std::string& file, std::optional<double> blank) : blank_(blank) { table_.file = file; }

    void line(std::string_view text, int at) {
        if (text.find('\0') != std::string_view::npos) fail(at, 1, "not a text file");
        if (trimmed(text).empty() || trimmed(text).front() == '#') return;
        const bool first = separator_ == 0;
        if (first) separator_ = separator_of(text);
        const std::vector<Cell> cells = split(text, separator_);
        if (first) {
            table_.columns.resize(cells.size());
            if (!cells.front().text.empty() && !number(cells.front().text)) return header(cells, at);
        }
        row(cells, at);
    }

    CsvTable finish() {
        if (separator_ == 0) fail(1, 1, "the table is empty");
        if (table_.rows() == 0) fail(table_.header_line, 1, "the table has no rows of numbers");
        return std::move(table_);
    }

private:
    void header(const std::vector<Cell>& cells, int at) {
        table_.header_line = at;
        for (const Cell& cell : cells)
            table_.header.emplace_back(cell.text);
    }

    void row(const std::vector<Cell>& cells, int at) {
        const std::size_t expected = table_.columns.size();
        if (cells.size() != expected) {
            fail(at, 1, fmt::format("{} cells, but the table has {} columns", cells.size(), expected));
        }
        for (std::size_t i = 0; i < expected; ++i)
            table_.columns[i].push_back(value(cells[i], at));
        table_.lines.push_back(at);
    }

    double value(const Cell& cell, int at) const {
        if (cell.text.empty()) {
            if (!blank_) fail(at, cell.column, "an empty cell where a number is needed");
            return *blank_;
        }
        const std::optional<double> parsed = number(cell.text);
        if (!parsed) fail(at, cell.column, fmt::format("\"{}\" is not a number", shown(cell.text)));
        if (!std::isfinite(*parsed)) fail(at, cell.column, fmt::format("\"{}\" is not finite", shown(cell.text)));
        return *parsed;
    }

    [[noreturn]] void fail(int at, int column, const std::string& message) const {
        throw SceneError({table_.file, at, column}, message);
    }

    std::optional<double> blank_;
    char separator_ = 0;  // known from the first line that counts
    CsvTable table_;
};

}  // namespace

std::optional<std::size_t> CsvTable::find(std::string_view name) const {
    const auto same = [&](const std::string& title) { return lower_case(title) == lower_case(name); };
    const auto found = std::find_if(header.begin(), header.end(), same);
    if (found == header.end()) return {};
    return static_cast<std::size_t>(found - header.begin());
}

const std::vector<double>& CsvTable::column(std::string_view name) const {
    const std::optional<std::size_t> index = find(name);
    if (index) return columns[*index];
    std::string titles;
    for (const std::string& title : header)
        titles += (titles.empty() ? "" : ", ") + shown(title);
    const std::string have = header.empty() ? "the table does not name its columns" : "its columns: " + titles;
    throw SceneError({file, std::max(header_line, 1), 1}, fmt::format("needs a column \"{}\" ({})", name, have));
}

void CsvTable::fail(std::size_t row, const std::string& message) const {
    throw SceneError({file, lines.at(row), 1}, message);
}

CsvTable parse_csv(std::string_view text, const std::string& file, std::optional<double> blank) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) text.remove_prefix(kByteOrderMark.size());
    Parser parser(file, blank);
    int at = 0;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        parser.line(text.substr(0, end), ++at);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return parser.finish();
}

CsvTable load_csv(const std::filesystem::path& path, std::optional<double> blank) {
    return parse_csv(load_text(path), path.string(), blank);
}

}  // namespace fluovox
