# What `cmake --install` puts where: library, headers, find_package(lithe) and pkg-config files.
include(CMakePackageConfigHelpers)
set(LITHE_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/lithe)

install(TARGETS lithe EXPORT lithe-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/lithe DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(EXPORT lithe-targets NAMESPACE lithe:: DESTINATION ${LITHE_CONFIG_DIR})
configure_package_config_file(cmake/lithe-config.cmake.in ${PROJECT_BINARY_DIR}/lithe-config.cmake
  INSTALL_DESTINATION ${LITHE_CONFIG_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/lithe-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lithe-config.cmake ${PROJECT_BINARY_DIR}/lithe-config-version.cmake
  cmake/lithe_dependencies.cmake DESTINATION ${LITHE_CONFIG_DIR})

# a static library leaves it to its user to link what it needs
set(LITHE_PC_OWN "-L\${libdir} -llithe")
set(LITHE_PC_NEEDS "-lcholmod -lmuparser -llapacke -llapack -lblas -lpng16 -lz -lgomp -lm")
if(BUILD_SHARED_LIBS)
  set(LITHE_PC_LIBS "${LITHE_PC_OWN}")
  set(LITHE_PC_REQUIRES "Requires.private: libfyaml")
  set(LITHE_PC_PRIVATE "Libs.private: ${LITHE_PC_NEEDS}")
else()
  set(LITHE_PC_LIBS "${LITHE_PC_OWN} ${LITHE_PC_NEEDS}")
  set(LITHE_PC_REQUIRES "Requires: libfyaml")
  set(LITHE_PC_PRIVATE "")
endif()
configure_file(cmake/lithe.pc.in ${PROJECT_BINARY_DIR}/lithe.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/lithe.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
