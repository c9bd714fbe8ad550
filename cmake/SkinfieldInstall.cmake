# The installed tree: the program, the headers, one static library a room, and what
# find_package(skinfield) needs to link them.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(SKINFIELD_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/skinfield)

foreach(part cholmod tetgen cgal)
  set_target_properties(skinfield_${part} PROPERTIES EXPORT_NAME ${part})
endforeach()
install(TARGETS skinfield ${SKINFIELD_TARGETS} skinfield_cholmod skinfield_metis skinfield_tetgen
  skinfield_cgal EXPORT skinfield-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT skinfield-targets NAMESPACE skinfield:: DESTINATION ${SKINFIELD_CMAKE_DIR})
install(TARGETS skinfield_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/skinfield
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(FILES LICENSE LICENSES.md CHANGELOG.md CITATION.cff README.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})

if(embree_VERSION VERSION_GREATER_EQUAL 4)
  set(SKINFIELD_EMBREE_VERSION 4)
else()
  set(SKINFIELD_EMBREE_VERSION 3.13)
endif()
configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/skinfield-config.cmake.in
  ${PROJECT_BINARY_DIR}/skinfield-config.cmake
  INSTALL_DESTINATION ${SKINFIELD_CMAKE_DIR})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/skinfield-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/skinfield-config.cmake
  ${PROJECT_BINARY_DIR}/skinfield-config-version.cmake
  DESTINATION ${SKINFIELD_CMAKE_DIR})
