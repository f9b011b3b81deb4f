#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// A table of numbers from a text file: columns separated by commas (or tabs, or semicolons; the first line tells).
///
/// Lines that start with `#` and empty lines are skipped. The first line that remains may name the columns; it does
/// when its first cell is not a number. Every line has as many cells as the first.
struct CsvTable {
    std::string file;
    std::vector<std::string> header;           ///< names as written, trimmed; empty when the file has none
    int header_line = 0;                       ///< 0 without a header
    std::vector<std::vector<double>> columns;  ///< equally long, finite
    std::vector<int> lines;                    ///< line in the file (from 1) of each row

    std::size_t rows() const { return lines.size(); }
    /// Number of the column with that name (without regard to case).
    std::optional<std::size_t> find(std::string_view name) const;
    /// The column with that name. Throws SceneError that lists the columns there are.
    const std::vector<double>& column(std::string_view name) const;
    /// Throws SceneError at a row.
    [[noreturn]] void fail(std::size_t row, const std::string& message) const;
};

/// Reads `text`, which messages call `file`. Empty cells get the value `blank`; without one they are errors.
/// Throws SceneError with line and column of the first cell that is no finite number, of a line with too few or too
/// many cells, or when there are no rows.
CsvTable parse_csv(std::string_view text, const std::string& file, std::optional<double> blank = {});

/// The same from a file; throws InputError as well when the file cannot be read.
CsvTable load_csv(const std::filesystem::path& path, std::optional<double> blank = {});

}  // namespace fluovox
