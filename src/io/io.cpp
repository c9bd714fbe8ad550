#include "skinfield/io/io.h"

#include "io/text.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/gmsh.h"
#include "skinfield/io/medit.h"
#include "skinfield/io/obj.h"
#include "skinfield/io/off.h"
#include "skinfield/io/ply.h"
#include "skinfield/io/stl.h"
#include "skinfield/io/svg.h"
#include "skinfield/io/tgf.h"

namespace skinfield {
namespace fs = std::filesystem;
namespace {

constexpr const char* kReadable =
    "meshes are read from .glb .gltf .obj .ply .off .stl .svg .mesh (MEDIT) .msh (Gmsh 2.2)";

const char* extension_for(FileFormat format) {
  switch (format) {
    case FileFormat::obj:
      return ".obj";
    case FileFormat::ply:
      return ".ply";
    case FileFormat::off:
      return ".off";
    case FileFormat::stl:
      return ".stl";
    case FileFormat::medit:
      return ".mesh";
    case FileFormat::gmsh:
      return ".msh";
    case FileFormat::gltf:
      return ".glb or .gltf";
    case FileFormat::svg:
      return ".svg";
    case FileFormat::tgf:
      return ".tgf";
    case FileFormat::fbx:
      return ".fbx";
    case FileFormat::unknown:
      break;
  }
  return "";
}

/// Formats whose files always begin with a mark.
bool has_mark(FileFormat format) {
  return format == FileFormat::ply || format == FileFormat::medit || format == FileFormat::gmsh;
}

/// The format to parse as, after comparing name and content.
FileFormat decide(const fs::path& path, std::string_view bytes) {
  const FileFormat named = format_of_extension(path), marked = format_of_bytes(bytes);
  if (named == FileFormat::fbx || marked == FileFormat::fbx) {
    throw InputError("FBX is not read", path.string(),
                     "convert it to glTF, for example with Blender (File > Export > glTF 2.0)");
  }
  if (text::trimmed(bytes).empty()) {
    throw InputError("the file is empty", path.string(), "export it again");
  }
  if (named == FileFormat::unknown && marked == FileFormat::unknown) {
    throw InputError("unknown file format", path.string(), kReadable);
  }
  if (named == FileFormat::unknown) return marked;
  if (marked != FileFormat::unknown && marked != named) {
    throw InputError(std::string("is named ") + extension_for(named) + " but holds another format",
                     path.string(), std::string("rename it to ") + extension_for(marked));
  }
  if (marked == FileFormat::unknown && (has_mark(named) || lower_extension(path) == ".glb")) {
    throw InputError("does not begin as a " + lower_extension(path) + " file", path.string(),
                     "it is damaged or named wrongly; export it again");
  }
  return named;
}

std::string read_regular(const fs::path& path) {
  std::string bytes = read_file(path);
  // UTF-8's byte order mark is no part of any of the formats.
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);
  return bytes;
}

MeshFile parse_obj_beside(const fs::path& path, std::string_view bytes) {
  const auto load = [&path](const std::string& file) -> std::optional<std::string> {
    try {
      return read_file(path.parent_path() / file);
    } catch (const InputError&) {
      return std::nullopt;
    }
  };
  return parse_obj(bytes, path.string(), load);
}

}  // namespace

FileFormat format_of_bytes(std::string_view bytes) {
  const std::string_view start = text::trimmed(bytes.substr(0, 512));
  if (bytes.starts_with("glTF")) return FileFormat::gltf;
  if (bytes.starts_with("Kaydara FBX") || start.starts_with("; FBX")) return FileFormat::fbx;
  if (is_binary_stl(bytes)) return FileFormat::stl;
  if (start.starts_with("ply\n") || start.starts_with("ply\r")) return FileFormat::ply;
  if (start.starts_with("$MeshFormat")) return FileFormat::gmsh;
  if (start.starts_with("MeshVersion")) return FileFormat::medit;
  if (start.starts_with("solid") && bytes.substr(0, 4096).find("facet") != bytes.npos) {
    return FileFormat::stl;
  }
  if (start.starts_with("<") && bytes.substr(0, 65536).find("<svg") != bytes.npos) {
    return FileFormat::svg;
  }
  if (start.starts_with("{") && bytes.find("\"asset\"") != bytes.npos) return FileFormat::gltf;
  const std::string_view word = start.substr(0, start.find_first_of(" \t\r\n"));
  if (word.size() <= 7 && word.ends_with("OFF")) return FileFormat::off;
  return FileFormat::unknown;
}

FileFormat format_of_extension(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".obj") return FileFormat::obj;
  if (extension == ".ply") return FileFormat::ply;
  if (extension == ".off") return FileFormat::off;
  if (extension == ".stl") return FileFormat::stl;
  if (extension == ".mesh") return FileFormat::medit;
  if (extension == ".msh") return FileFormat::gmsh;
  if (extension == ".glb" || extension == ".gltf") return FileFormat::gltf;
  if (extension == ".svg") return FileFormat::svg;
  if (extension == ".tgf") return FileFormat::tgf;
  if (extension == ".fbx") return FileFormat::fbx;
  return FileFormat::unknown;
}

Asset read_asset(const fs::path& path, const ReadOptions& options) {
  const std::string bytes = read_regular(path);
  const std::string name = path.string();
  switch (decide(path, bytes)) {
    case FileFormat::obj:
      return asset_from(parse_obj_beside(path, bytes), name, options);
    case FileFormat::ply:
      return asset_from(parse_ply(bytes, name), name, options);
    case FileFormat::off:
      return asset_from(parse_off(bytes, name), name, options);
    case FileFormat::stl:
      return asset_from(parse_stl(bytes, name), name, options);
    case FileFormat::medit:
      return asset_from(parse_medit(bytes, name), name, options);
    case FileFormat::gmsh:
      return asset_from(parse_gmsh(bytes, name), name, options);
    case FileFormat::svg:
      return asset_from(parse_svg(bytes, name), name, options);
    case FileFormat::gltf: {
      Asset asset = read_gltf(path);
      if (options.up != Up::y || options.scale != 1) {
        asset.warnings.push_back("axes and scale are not changed: glTF is y up and in metres");
      }
      return asset;
    }
    case FileFormat::tgf:
      throw InputError("is a skeleton, not a mesh", name, "give it with --skeleton");
    case FileFormat::fbx:
    case FileFormat::unknown:
      break;
  }
  throw InputError("unknown file format", name, kReadable);
}

Skeleton read_skeleton(const fs::path& path, const ReadOptions& options) {
  const std::string name = path.string();
  const std::string bytes = read_regular(path);
  const FileFormat format = decide(path, bytes);
  if (format == FileFormat::tgf) {
    Skeleton skeleton = parse_tgf(bytes, name);
    transform_skeleton(skeleton, options);
    return skeleton;
  }
  if (format == FileFormat::gltf) return read_gltf_skeleton(path);
  throw InputError("is no skeleton", name, "skeletons are read from .tgf, .glb and .gltf");
}

}  // namespace skinfield
