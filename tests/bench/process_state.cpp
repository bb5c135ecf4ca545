// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/process_state.h"

#include <unistd.h>

#include <fstream>
#include <sstream>
#include <string>

#include "common/base/errors.h"

namespace sheen {
namespace {

std::filesystem::path folder_of(pid_t process) {
  return "/proc/" + std::to_string(process);
}

}  // namespace

double processor_seconds(const std::filesystem::path& file) {
  std::string stat;
  std::getline(std::ifstream(file), stat);
  std::istringstream fields(stat.substr(stat.rfind(')') + 1));  // the name before may have spaces
  std::string other;
  for (int i = 3; i < 14; ++i) fields >> other;
  double user = 0, system = 0;
  if (!(fields >> user >> system)) throw Error(file.string() + " cannot be read");
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

double processor_seconds(pid_t process) {
  return processor_seconds(folder_of(process) / "stat");
}

double resident_mb(pid_t process) {
  std::ifstream status(folder_of(process) / "status");
  for (std::string word; status >> word;)
    if (double kb = 0; word == "VmRSS:" && status >> kb) return kb / 1e3;
  throw Error("the memory of process " + std::to_string(process) + " cannot be read");
}

}  // namespace sheen
