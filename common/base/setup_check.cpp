// SPDX-License-Identifier: Apache-2.0
#include "common/base/setup_check.h"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"

namespace sheen {

const char* to_string(Finding finding) {
  switch (finding) {
    case Finding::kOk:
      return "OK";
    case Finding::kWarn:
      return "WARN";
    case Finding::kFail:
      break;
  }
  return "FAIL";
}

SetupCheck check_loading(const std::string& name, const std::function<std::string()>& load, const std::string& remedy) {
  try {
    return {name, Finding::kOk, load()};
  } catch (const Error& error) {
    return {name, Finding::kFail, error.what() + (remedy.empty() ? "" : "; " + remedy)};
  }
}

void report_checks(const std::vector<SetupCheck>& checks, bool json) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SetupCheck& check : checks) {
    if (json)
      list.push_back({{"check", check.name}, {"finding", to_string(check.finding)}, {"text", check.text}});
    else
      std::cout << to_string(check.finding) << '\t' << check.name << ": " << check.text << '\n';
  }
  if (json) std::cout << list.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  const auto failed = std::count_if(checks.begin(), checks.end(),
                                    [](const SetupCheck& check) { return check.finding == Finding::kFail; });
  if (failed > 0) throw Error(std::to_string(failed) + " of " + std::to_string(checks.size()) + " checks failed");
}

}  // namespace sheen
