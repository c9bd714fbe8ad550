# Everything Skinfield links, found once. LICENSES.md says what each profile contains.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nanoflann REQUIRED)
find_package(pugixml REQUIRED)

# Embree 4 if there is one, else 3.13 (Debian 12); only src/geometry/ray_scene.cpp knows which.
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED)
endif()

# CHOLMOD's supernodal module is GPL, so that the permissive profile does without.
add_library(skinfield_cholmod INTERFACE)
if(SKINFIELD_PROFILE STREQUAL "full")
  find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
  find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
  target_include_directories(skinfield_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
  target_link_libraries(skinfield_cholmod INTERFACE ${CHOLMOD_LIBRARY})
  target_compile_definitions(skinfield_cholmod INTERFACE SKINFIELD_HAVE_CHOLMOD=1)
endif()

# Orders large factors with less fill than minimum degree; only src/solve/ordering.cpp knows it.
add_library(skinfield_metis INTERFACE)
find_path(METIS_INCLUDE_DIR metis.h)
find_library(METIS_LIBRARY metis)
if(METIS_INCLUDE_DIR AND METIS_LIBRARY)
  target_include_directories(skinfield_metis SYSTEM INTERFACE ${METIS_INCLUDE_DIR})
  target_link_libraries(skinfield_metis INTERFACE ${METIS_LIBRARY})
  target_compile_definitions(skinfield_metis INTERFACE SKINFIELD_HAVE_METIS=1)
endif()

# TetGen (AGPL) and CGAL's alpha wrap (GPL) make tetrahedra of surfaces, CGAL's mesher (GPL)
# triangles of outlines; header-only CGAL needs GMP and MPFR. Each is known to one file of
# src/domain.
add_library(skinfield_tetgen INTERFACE)
add_library(skinfield_cgal INTERFACE)
if(SKINFIELD_PROFILE STREQUAL "full")
  find_path(TETGEN_INCLUDE_DIR tetgen.h REQUIRED)
  find_library(TETGEN_LIBRARY tet REQUIRED)
  target_include_directories(skinfield_tetgen SYSTEM INTERFACE ${TETGEN_INCLUDE_DIR})
  target_link_libraries(skinfield_tetgen INTERFACE ${TETGEN_LIBRARY})
  target_compile_definitions(skinfield_tetgen INTERFACE SKINFIELD_HAVE_TETGEN=1)
  find_path(CGAL_INCLUDE_DIR CGAL/alpha_wrap_3.h REQUIRED)
  find_library(GMP_LIBRARY gmp REQUIRED)
  find_library(MPFR_LIBRARY mpfr REQUIRED)
  target_include_directories(skinfield_cgal SYSTEM INTERFACE ${CGAL_INCLUDE_DIR})
  target_link_libraries(skinfield_cgal INTERFACE ${MPFR_LIBRARY} ${GMP_LIBRARY})
  target_compile_definitions(skinfield_cgal INTERFACE SKINFIELD_HAVE_CGAL=1)
  # Its interval arithmetic sets the rounding mode.
  set_source_files_properties(${PROJECT_SOURCE_DIR}/src/domain/alpha_wrap.cpp
    ${PROJECT_SOURCE_DIR}/src/domain/planar_mesher.cpp PROPERTIES
    COMPILE_OPTIONS -frounding-math)
endif()
