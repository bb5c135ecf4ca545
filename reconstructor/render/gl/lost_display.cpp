// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/lost_display.h"

#include <X11/Xlib.h>

extern "C" Display* glfwGetX11Display();  // of glfw3native.h, which would want the headers of XRandR too

namespace sheen {

void survive_lost_display(bool& lost) {
  XSetIOErrorHandler([](Display*) { return 0; });  // the default one ends the program before the other is asked
  XSetIOErrorExitHandler(
      glfwGetX11Display(), [](Display*, void* flag) { *static_cast<bool*>(flag) = true; }, &lost);
}

}  // namespace sheen
