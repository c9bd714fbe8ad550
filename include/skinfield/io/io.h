// One door for all formats: characters and skeletons from any file that is understood.
#pragma once

#include "skinfield/io/asset.h"
#include "skinfield/io/mesh_file.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace skinfield {

enum class FileFormat { unknown, obj, ply, off, stl, medit, gmsh, gltf, svg, tgf, fbx };

/// What the first bytes say; `unknown` for formats without a mark (OBJ, TGF).
FileFormat format_of_bytes(std::string_view bytes);
/// What the extension says.
FileFormat format_of_extension(const std::filesystem::path& path);

/// Reads a character file: OBJ, PLY, OFF, STL, MEDIT .mesh, Gmsh 2.2 .msh, SVG, glTF, GLB. The
/// extension chooses the parser; a file whose first bytes say otherwise is refused, and one
/// without a known extension is read by its first bytes. A format without skeletons gives one
/// character with an empty skeleton. `options` apply to all but glTF, whose axes and units are
/// fixed. Closed flat polylines of OBJ and SVG are the mesh's outline. Throws InputError with the
/// file, the place in it and the remedy.
Asset read_asset(const std::filesystem::path& path, const ReadOptions& options = {});

/// Reads joints from TGF, or from a glTF file's skin. A TGF is turned and scaled by `options`
/// like the mesh it belongs to. Handles are made by rig's rules. Throws InputError.
Skeleton read_skeleton(const std::filesystem::path& path, const ReadOptions& options = {});

}  // namespace skinfield
