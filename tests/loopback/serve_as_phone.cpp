// SPDX-License-Identifier: Apache-2.0
// serve_as_phone RECORDING: sends the frames of a simulated rig as a telephone's camera app does, 12 a second, again
// and again, until it is told to stop. Prints its address first.
#include <iostream>
#include <thread>

#include "common/base/stop_signal.h"
#include "tests/loopback/phone.h"

int main(int argc, char** argv) {
  using namespace sheen;
  if (argc != 2) return 2;
  install_stop_signals();
  testing::MjpegServer phone(testing::again_and_again(testing::jpegs_of(load_rig_recording(argv[1])), 6),
                             {.between = std::chrono::milliseconds(40)});
  std::cout << phone.address() << std::endl;
  while (!stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}
