# The comparison with other libraries that subdivide meshes: relief_mesh_peers. Those that are not installed are left
# out. It is not installed, as CGAL's licence is the GPL.
add_library(relief_mesh_peer STATIC mesh_peer.cpp relief_meshes.cpp)
target_include_directories(relief_mesh_peer PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(relief_mesh_peer PUBLIC relief::multires PRIVATE relief_warnings)

# Debian's configuration of OpenSubdiv names libraries that its package has not.
find_path(OPENSUBDIV_INCLUDE opensubdiv/version.h)
find_library(OPENSUBDIV_LIBRARY osdCPU)
if(OPENSUBDIV_INCLUDE AND OPENSUBDIV_LIBRARY)
    file(STRINGS ${OPENSUBDIV_INCLUDE}/opensubdiv/version.h version REGEX "define OPENSUBDIV_VERSION v")
    string(REGEX REPLACE ".* v([0-9]+)_([0-9]+)_([0-9]+).*" "\\1.\\2.\\3" OPENSUBDIV_VERSION "${version}")
endif()
find_package(OpenMesh QUIET CONFIG)
if(TARGET OpenMeshCore)
    get_target_property(include OpenMeshCore INTERFACE_INCLUDE_DIRECTORIES)
    file(STRINGS ${include}/OpenMesh/Core/System/config.h version REGEX "^#define OM_VERSION ")
    string(REGEX REPLACE ".*0x([0-9]+)0([0-9])0([0-9]).*" "\\1.\\2.\\3" OPENMESH_VERSION "${version}")
endif()
# The headers alone: CGAL's own configuration asks for libraries of numbers that subdivision does not need.
find_path(CGAL_INCLUDE CGAL/version.h)
if(CGAL_INCLUDE)
    file(STRINGS ${CGAL_INCLUDE}/CGAL/version.h version REGEX "define CGAL_VERSION [0-9]")
    string(REGEX REPLACE ".*VERSION ([0-9.]+).*" "\\1" CGAL_PEER_VERSION "${version}")
endif()
relief_peer(relief_mesh_peer OPENSUBDIV opensubdiv_peers.cpp "${OPENSUBDIV_VERSION}" ${OPENSUBDIV_LIBRARY})
relief_peer(relief_mesh_peer OPENMESH openmesh_peers.cpp "${OPENMESH_VERSION}" OpenMeshCore)
relief_peer(relief_mesh_peer CGAL cgal_peers.cpp "${CGAL_PEER_VERSION}")

add_executable(relief_mesh_peers mesh_peers.cpp)
target_link_libraries(relief_mesh_peers PRIVATE relief_warnings relief_mesh_peer relief::io nlohmann_json::nlohmann_json)

if(RELIEF_TESTS)
    find_package(GTest REQUIRED)
    include(GoogleTest)
    add_executable(mesh_peers_tests mesh_peers_test.cpp)
    target_link_libraries(mesh_peers_tests PRIVATE relief_warnings relief_mesh_peer GTest::gtest GTest::gtest_main)
    gtest_discover_tests(mesh_peers_tests DISCOVERY_MODE PRE_TEST PROPERTIES LABELS peers TIMEOUT 300)
endif()
