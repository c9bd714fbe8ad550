// What `render` and `interpolate` share: how a character is looked at.
#pragma once

#include "cli.h"

#include "skinfield/render/render.h"

namespace skinfield::cli {

/// --width, --height, --yaw, --pitch and --caption; their names, for refusing them.
void add_picture_options(CLI::App& verb, RenderOptions& render);
const std::vector<std::string>& picture_option_names();

/// Flat shapes are seen from the front, without perspective, unless yaw or pitch is given.
void look_at_plane(const CLI::App& verb, const Asset& asset, CameraOptions& camera);

}  // namespace skinfield::cli
