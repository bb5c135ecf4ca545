// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/goal_rows.h"

#include <cstdio>

#include "common/base/command_line.h"
#include "common/base/files.h"

namespace sheen {
namespace {

std::string printed(const std::optional<double>& value) {
  char text[32] = "-";
  if (value) std::snprintf(text, sizeof text, "%.5g", *value);
  return text;
}

}  // namespace

GoalRow at_most(double goal, std::optional<double> moonshot, std::string name, double value, std::string unit,
                nlohmann::json compared_with) {
  return {std::move(name), value, std::move(unit), goal, value <= goal, std::move(compared_with), moonshot};
}

GoalRow at_least(double goal, std::optional<double> moonshot, std::string name, double value, std::string unit,
                 nlohmann::json compared_with) {
  return {std::move(name), value, std::move(unit), goal, value >= goal, std::move(compared_with), moonshot};
}

void GoalReport::add(const GoalRow& row) {
  const char* verdict = !row.goal ? "" : row.holds ? "holds" : "MISSED";
  const std::string moonshot = row.moonshot ? " (" + printed(row.moonshot) + ")" : "";
  std::printf("%-52s %10.5g %-8s goal %-18s %-6s", row.name.c_str(), row.value, row.unit.c_str(),
              (printed(row.goal) + moonshot).c_str(), verdict);
  for (const auto& [name, value] : row.compared_with.items())
    std::printf("  %s %s", name.c_str(),
                value.is_number() ? printed(value.get<double>()).c_str() : value.dump().c_str());
  std::printf("\n");
  std::fflush(stdout);
  nlohmann::json json{{"name", row.name}, {"value", row.value}, {"unit", row.unit},
                      {"goal", nullptr},  {"holds", row.holds}, {"compared_with", row.compared_with}};
  if (row.goal) json["goal"] = *row.goal;
  if (row.moonshot) json["moonshot"] = *row.moonshot;
  json_["rows"].push_back(std::move(json));
}

int measure_goals(int argc, char** argv, const std::string& description,
                  const std::function<void(GoalReport&)>& measure) {
  CommandLine program("", description);
  std::string path;
  program.option("--json", path, "report to write");
  program.callback([&] {
    GoalReport report;
    measure(report);
    if (!path.empty()) write_file(path, report.json().dump(2) + "\n");
  });
  return program.run(argc, argv);
}

}  // namespace sheen
