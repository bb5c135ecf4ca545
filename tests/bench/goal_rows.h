// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace sheen {

/// A figure, what it should be, and what it is compared with in the same run.
struct GoalRow {
  std::string name;
  double value = 0;
  std::string unit;
  std::optional<double> goal;  ///< none: a figure that belongs beside the goals and always holds
  bool holds = true;
  nlohmann::json compared_with = nlohmann::json::object();  ///< name: value
  std::optional<double> moonshot = {};                      ///< more than the goal
};

/// A row that holds while its value is at most, or at least, the goal.
GoalRow at_most(double goal, std::optional<double> moonshot, std::string name, double value, std::string unit,
                nlohmann::json compared_with = nlohmann::json::object());
GoalRow at_least(double goal, std::optional<double> moonshot, std::string name, double value, std::string unit,
                 nlohmann::json compared_with = nlohmann::json::object());

/// Rows on their way to the screen and to a file.
class GoalReport {
 public:
  /// Prints the row at once.
  void add(const GoalRow& row);
  const nlohmann::json& json() const { return json_; }

 private:
  nlohmann::json json_{{"rows", nlohmann::json::array()}};
};

/// main() of a program that measures goals: `[--json FILE]`. Exit status 1 when the file cannot be written.
int measure_goals(int argc, char** argv, const std::string& description,
                  const std::function<void(GoalReport&)>& measure);

}  // namespace sheen
