# The libraries Headway stands on, all from Debian 12 (scripts/setup installs them).

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(embree 3 REQUIRED)
find_package(octomap REQUIRED)
find_package(Qhull REQUIRED)
find_package(HWY REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto SSL)

# Beast and Asio are headers only.
find_package(Boost 1.74 REQUIRED)
add_library(headway_beast INTERFACE)
target_link_libraries(headway_beast INTERFACE Boost::headers)
target_compile_definitions(headway_beast INTERFACE BOOST_ASIO_DISABLE_CONCEPTS BOOST_ASIO_NO_DEPRECATED)

add_library(headway_octomap INTERFACE)
target_include_directories(headway_octomap SYSTEM INTERFACE ${OCTOMAP_INCLUDE_DIRS})
target_link_libraries(headway_octomap INTERFACE ${OCTOMAP_LIBRARIES})

add_library(headway_embree INTERFACE)
target_link_libraries(headway_embree INTERFACE embree)

# libusb comes with a file for pkg-config only.
find_path(LIBUSB_INCLUDE_DIR libusb-1.0/libusb.h REQUIRED)
find_library(LIBUSB_LIBRARY usb-1.0 REQUIRED)
add_library(headway_libusb INTERFACE)
target_include_directories(headway_libusb SYSTEM INTERFACE ${LIBUSB_INCLUDE_DIR})
target_link_libraries(headway_libusb INTERFACE ${LIBUSB_LIBRARY})

# Debian's zstd comes without a file for CMake.
find_path(ZSTD_INCLUDE_DIR zstd.h REQUIRED)
find_library(ZSTD_LIBRARY zstd REQUIRED)
add_library(headway_zstd INTERFACE)
target_include_directories(headway_zstd SYSTEM INTERFACE ${ZSTD_INCLUDE_DIR})
target_link_libraries(headway_zstd INTERFACE ${ZSTD_LIBRARY})

find_path(SYSTEMD_INCLUDE_DIR systemd/sd-daemon.h REQUIRED)
find_library(SYSTEMD_LIBRARY systemd REQUIRED)
add_library(headway_systemd INTERFACE)
target_include_directories(headway_systemd SYSTEM INTERFACE ${SYSTEMD_INCLUDE_DIR})
target_link_libraries(headway_systemd INTERFACE ${SYSTEMD_LIBRARY})

# libjpeg-turbo's own configuration also asks for libjpeg's files, which lie in a package that is not needed.
find_path(TURBOJPEG_INCLUDE_DIR turbojpeg.h REQUIRED)
find_library(TURBOJPEG_LIBRARY turbojpeg REQUIRED)
add_library(headway_turbojpeg INTERFACE)
target_include_directories(headway_turbojpeg SYSTEM INTERFACE ${TURBOJPEG_INCLUDE_DIR})
target_link_libraries(headway_turbojpeg INTERFACE ${TURBOJPEG_LIBRARY})

# Debian's OpenCVConfig.cmake comes only with libopencv-dev, which drags in Qt, VTK and Java;
# the modules used here are found by themselves.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(headway_opencv INTERFACE)
target_include_directories(headway_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
foreach(module core imgproc imgcodecs calib3d aruco)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
  target_link_libraries(headway_opencv INTERFACE ${OPENCV_${module}_LIBRARY})
endforeach()

if(HEADWAY_TESTS)
  find_library(OPENCV_surface_matching_LIBRARY opencv_surface_matching REQUIRED)
  find_package(GTest REQUIRED)
  find_package(rapidcheck REQUIRED)
endif()
if(HEADWAY_BENCH)
  find_package(benchmark REQUIRED)
endif()
