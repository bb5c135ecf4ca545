// SPDX-License-Identifier: Apache-2.0
#include "common/base/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <numeric>
#include <optional>

#include "common/base/errors.h"
#include "common/base/report_file.h"

namespace sheen {
namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUsage = 2;

template <typename T>
std::optional<T> whole(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Levenshtein: letters to change, add or leave away.
std::size_t slips(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, above + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

void suggest_subcommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-' || !app.get_subcommands().empty()) return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  const std::string meant = nearest_word(argv[1], names);
  std::fprintf(stderr, "%s has no command \"%s\"%s\n", app.get_name().c_str(), argv[1],
               meant.empty() ? "" : ("; did you mean \"" + meant + "\"?").c_str());
}

}  // namespace

int run_program(CLI::App& app, int argc, char** argv) {
  const auto tell = [&app](const std::exception& error, int status) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), error.what());
    return status;
  };
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (app.exit(error) != kDone) {
        suggest_subcommand(app, argc, argv);
        return kWrongUsage;
      }
    }
    finish_standard_output();
    return kDone;
  } catch (const ConfigError& error) {
    return tell(error, kWrongUsage);
  } catch (const std::exception& error) {
    return tell(error, kFailed);
  }
}

CLI::Validator number_in(double least, double most) {
  char range[80];
  std::snprintf(range, sizeof range, "%g..%g", least, most);
  return {[least, most, range = std::string(range)](std::string& text) -> std::string {
            const auto value = whole<double>(text);
            return value && *value >= least && *value <= most ? "" : "\"" + text + "\" is not a number in " + range;
          },
          range};
}

CLI::Validator whole_number_in(std::int64_t least, std::int64_t most) {
  const std::string range = std::to_string(least) + ".." + std::to_string(most);
  return {[least, most, range](std::string& text) -> std::string {
            const auto value = whole<std::int64_t>(text);
            return value && *value >= least && *value <= most ? ""
                                                              : "\"" + text + "\" is not a whole number in " + range;
          },
          range};
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& words) {
  constexpr std::size_t kMostSlips = 2;
  std::string nearest;
  std::size_t fewest = kMostSlips + 1;
  for (const std::string& candidate : words) {
    const std::size_t n = slips(word, candidate);
    if (n >= fewest || n >= candidate.size()) continue;
    fewest = n;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace sheen
