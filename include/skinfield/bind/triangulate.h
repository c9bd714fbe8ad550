// Flat outlines become triangles: for binding, for pictures, for glTF.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/io/asset.h"

namespace skinfield {

/// Gives a character that is an outline its triangles, with about `nodes` vertices (0: those of the
/// outline alone) and its handles as vertices and edges. The input's vertices, and with them the
/// rows of weight matrices, stay the outline's. Others are left as they are.
/// @throws DomainError as mesh_outline does; for nodes = 0 also if the outline crosses itself.
void triangulate_outline(Character& character, int nodes, const Progress& progress = {});

/// Lets a triangulated outline's inner vertices count as input, behind the others: formats that
/// hold triangles need rows for them.
void count_inner_vertices(Character& character);

}  // namespace skinfield
