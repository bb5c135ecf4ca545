// SPDX-License-Identifier: Apache-2.0
// consumer MODEL X Y Z: for each line "triangle u v" of standard input, its colour as that eye sees it.
#include <sheen/light_field.h>
#include <cstdio>
#include <cstdlib>
#include <exception>

int main(int, char** arguments) try {
  const sheen::LightField object(arguments[1]);
  const auto view = object.from({std::atof(arguments[2]), std::atof(arguments[3]), std::atof(arguments[4])});
  unsigned triangle = 0;
  float u = 0, v = 0;
  while (std::scanf("%u %f %f", &triangle, &u, &v) == 3) {
    const auto colour = view.shade(triangle, u, v);
    std::printf("%.9g %.9g %.9g\n", colour[0], colour[1], colour[2]);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
