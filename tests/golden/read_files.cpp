// SPDX-License-Identifier: Apache-2.0
// Reads model files and holds them against what stands beside them, in any build: read_files FILE ... compares FILE
// with FILE.txt, read_files --print FILE prints what such a file would hold. Exit status 1 where anything differs.
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/golden/contents.h"

namespace {

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

int main(int argc, char** argv) {
  const bool print = argc == 3 && std::string(argv[1]) == "--print";
  if (argc < 2) {
    std::fprintf(stderr, "usage: read_files FILE ... | read_files --print FILE\n");
    return 2;
  }
  int status = 0;
  for (int i = print ? 2 : 1; i < argc; ++i) {
    const std::string file = argv[i];
    try {
      const sheen::FileContents found = sheen::contents_of(bytes_of(file), file);
      if (print) {
        std::fputs(found.text().c_str(), stdout);
        continue;
      }
      const std::string off = differences(sheen::FileContents::parsed(bytes_of(file + ".txt")), found);
      std::printf("%s: %s\n", file.c_str(), off.empty() ? "as expected" : off.c_str());
      if (!off.empty()) status = 1;
    } catch (const std::exception& error) {
      std::printf("%s\n", error.what());
      status = 1;
    }
  }
  return status;
}
