# Debian packages: `plumbline` (program, plugins, pipelines, man pages, completion) and `plumbline-dev` (headers, libraries, kits).
# scripts/package makes them with cpack.
set(package_folder ${PROJECT_BINARY_DIR}/package)
configure_file(${PROJECT_SOURCE_DIR}/LICENSE ${package_folder}/copyright COPYONLY)
file(READ ${PROJECT_SOURCE_DIR}/NOTICE.md notice)
file(APPEND ${package_folder}/copyright "\n${notice}\nOn Debian the texts of the GNU licences lie in /usr/share/common-licenses (GPL-2, GPL-3, LGPL-2.1, LGPL-3).\n")
foreach(package plumbline plumbline-dev)
  if(package STREQUAL plumbline)
    set(component Unspecified)
  else()
    set(component Development)
  endif()
  install(FILES ${package_folder}/copyright DESTINATION share/doc/${package} COMPONENT ${component})
  install(FILES ${package_folder}/changelog.gz DESTINATION share/doc/${package} COMPONENT ${component} OPTIONAL)
endforeach()
install(DIRECTORY ${package_folder}/man1 DESTINATION share/man OPTIONAL)  # scripts/package writes them

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME plumbline)
set(CPACK_PACKAGE_CONTACT "Plumbline maintainers <maintainers@users.noreply.h-seed-65ce5b17.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL Unspecified Development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME plumbline)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS "libjs-three, python3-flatbuffers, python3-numpy")
set(CPACK_COMPONENT_UNSPECIFIED_DESCRIPTION "Pipelines in YAML bring photographs of fiducial markers, total stations and
a design (IFC) together: adjustment with covariances, verdicts against the
design, an as-built IFC and work orders for what has to be set again.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME plumbline-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "plumbline (= ${PROJECT_VERSION}), cmake, libeigen3-dev, libflatbuffers-dev, flatbuffers-compiler, libyaml-cpp-dev, libfmt-dev, nlohmann-json3-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers, libraries and conformance kits for plugins, as
find_package(Plumbline) finds them: the contract of a node, the artifacts,
the libraries of adjustment and geometry, and what tests a node.")
include(CPack)
