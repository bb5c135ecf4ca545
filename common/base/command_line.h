// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

// What the programs use of CLI11. Its headers take a compiler seconds, also in a file that uses none of it: one file
// includes them.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sheen {

/// What a value must be. Another one is wrong usage.
struct ValueCheck {
  std::function<std::string(const std::string&)> error;  ///< what is wrong with a value; empty: nothing
  std::string allowed = {};                              ///< what is right, in a word for the help
};
ValueCheck number_in(double least, double most);                    ///< NaN and infinity are in no range
ValueCheck whole_number_in(std::int64_t least, std::int64_t most);  ///< in decimal digits
ValueCheck range(int least, int most);                              ///< of whole numbers, also octal and hexadecimal
ValueCheck one_of(std::initializer_list<std::string> words);
ValueCheck one_of(std::initializer_list<int> numbers);

/// What a command is told: an option, a flag, or an argument that has no dashes. Copies are the same option.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required();
  Option check(const ValueCheck& check);
  Option show_default();  ///< the help shows the value that the target has now
  Option group(const std::string& heading);
  Option needs(Option other);
  Option excludes(std::initializer_list<Option> others);
  // Where the target is a vector:
  Option delimiter(char between);
  Option expected(int values);
  Option one_each_time();  ///< one value follows the option, which may be given several times

  bool given() const;  ///< once the command line has been read

 private:
  CLI::Option* option_;
};

/// A program or a subcommand: what it is told, and its work. Copies are the same command; they live as long as its
/// CommandLine.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command subcommand(const std::string& name, const std::string& help);
  void require_subcommand();
  /// Values are read into `target`, which is as it was where none is given. Its type is one of those at the end of
  /// command_line.cpp. A name without dashes is that of an argument.
  template <typename T>
  Option option(const std::string& name, T& target, const std::string& help);
  Option flag(const std::string& name, bool& target, const std::string& help);
  /// The work, done once the command line has been read. Where a subcommand is given, that one's is done instead.
  void callback(std::function<void()> work);

 private:
  CLI::App* app_;
};

/// A program whose work happens in callbacks.
class CommandLine : public Command {
 public:
  /// An empty name: that of the file.
  CommandLine(const std::string& name, const std::string& help);
  ~CommandLine();

  void version(const std::string& version);
  /// The exit status: 0 done, 1 failed, 2 wrong usage (ConfigError too); what failed is printed on standard error, with
  /// the nearest name where a subcommand was misspelt. Standard output that could not be written is a failure.
  int run(int argc, const char* const* argv);

 private:
  explicit CommandLine(std::unique_ptr<CLI::App> app);

  std::unique_ptr<CLI::App> app_;
};

/// The one of `words` that `word` is most like, within two slips; empty when none is.
std::string nearest_word(const std::string& word, const std::vector<std::string>& words);

}  // namespace sheen
