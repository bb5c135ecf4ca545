// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// From here on the end of GLFW's X server sets `lost`, where Xlib by itself would end the whole program, and with it a
/// capture. Every later call of Xlib does nothing. After `glfwInit`; `lost` must live until `glfwTerminate`.
void survive_lost_display(bool& lost);

}  // namespace sheen
