// SPDX-License-Identifier: Apache-2.0
#include "common/base/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <filesystem>
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

void suggest_subcommand(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2 || argv[1][0] == '-' || !app.get_subcommands().empty()) return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  const std::string meant = nearest_word(argv[1], names);
  std::fprintf(stderr, "%s has no command \"%s\"%s\n", app.get_name().c_str(), argv[1],
               meant.empty() ? "" : ("; did you mean \"" + meant + "\"?").c_str());
}

/// "--name[=value]" is an option that may stand without a value and then has this one.
std::pair<std::string, std::string> split_name(const std::string& name) {
  const std::size_t open = name.find("[=");
  if (open == std::string::npos) return {name, ""};
  return {name.substr(0, open), name.substr(open + 2, name.size() - open - 3)};
}

ValueCheck checked_by(const CLI::Validator& validator) {
  return {validator, validator.get_description()};
}

}  // namespace

ValueCheck number_in(double least, double most) {
  char range[80];
  std::snprintf(range, sizeof range, "%g..%g", least, most);
  return {[least, most, range = std::string(range)](const std::string& text) -> std::string {
            const auto value = whole<double>(text);
            return value && *value >= least && *value <= most ? "" : "\"" + text + "\" is not a number in " + range;
          },
          range};
}

ValueCheck whole_number_in(std::int64_t least, std::int64_t most) {
  const std::string range = std::to_string(least) + ".." + std::to_string(most);
  return {[least, most, range](const std::string& text) -> std::string {
            const auto value = whole<std::int64_t>(text);
            return value && *value >= least && *value <= most ? ""
                                                              : "\"" + text + "\" is not a whole number in " + range;
          },
          range};
}

ValueCheck range(int least, int most) {
  return checked_by(CLI::Range(least, most));
}

ValueCheck one_of(std::initializer_list<std::string> words) {
  return checked_by(CLI::IsMember(std::vector<std::string>(words)));
}

ValueCheck one_of(std::initializer_list<int> numbers) {
  return checked_by(CLI::IsMember(std::vector<int>(numbers)));
}

Option Option::required() {
  option_->required();
  return *this;
}

Option Option::check(const ValueCheck& check) {
  option_->check(check.error, check.allowed);
  return *this;
}

Option Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option Option::group(const std::string& heading) {
  option_->group(heading);
  return *this;
}

Option Option::needs(Option other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(std::initializer_list<Option> others) {
  for (const Option& other : others) option_->excludes(other.option_);
  return *this;
}

Option Option::delimiter(char between) {
  option_->delimiter(between);
  return *this;
}

Option Option::expected(int values) {
  option_->expected(values);
  return *this;
}

Option Option::one_each_time() {
  option_->allow_extra_args(false);
  return *this;
}

bool Option::given() const {
  return !option_->empty();
}

Command Command::subcommand(const std::string& name, const std::string& help) {
  return Command(app_->add_subcommand(name, help));
}

void Command::require_subcommand() {
  app_->require_subcommand(1);
}

template <typename T>
Option Command::option(const std::string& name, T& target, const std::string& help) {
  const auto [bare, left_out] = split_name(name);
  CLI::Option* option = app_->add_option(bare, target, help);
  if (!left_out.empty()) option->expected(0, 1)->default_str(left_out);
  return Option(option);
}

Option Command::flag(const std::string& name, bool& target, const std::string& help) {
  return Option(app_->add_flag(name, target, help));
}

void Command::callback(std::function<void()> work) {
  app_->callback([app = app_, work = std::move(work)] {
    if (app->get_subcommands().empty()) work();
  });
}

CommandLine::CommandLine(const std::string& name, const std::string& help)
    : CommandLine(std::make_unique<CLI::App>(help, name)) {}

CommandLine::CommandLine(std::unique_ptr<CLI::App> app) : Command(app.get()), app_(std::move(app)) {}

CommandLine::~CommandLine() = default;

void CommandLine::version(const std::string& version) {
  app_->set_version_flag("--version", version);
}

int CommandLine::run(int argc, const char* const* argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond the limit of `ulimit -f` is an error of its writer, told like others
  const auto tell = [this](const std::exception& error, int status) {
    std::fprintf(stderr, "%s: %s\n", app_->get_name().c_str(), error.what());
    return status;
  };
  try {
    try {
      app_->parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (app_->exit(error) != kDone) {
        suggest_subcommand(*app_, argc, argv);
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

template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, std::filesystem::path&, const std::string&);
template Option Command::option(const std::string&, std::optional<int>&, const std::string&);
template Option Command::option(const std::string&, std::optional<std::uint64_t>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<int>&, const std::string&);
template Option Command::option(const std::string&, std::vector<double>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::filesystem::path>&, const std::string&);

}  // namespace sheen
