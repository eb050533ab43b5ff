# opencv::core, opencv::imgproc, opencv::imgcodecs, opencv::calib3d from the small Debian packages, which come without
# OpenCVConfig.cmake (only libopencv-dev, 500 MB more, has it).
find_path(OpenCvModules_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(OpenCvModules_LIBRARIES "")
foreach(module core imgproc imgcodecs calib3d)
  find_library(OpenCvModules_${module}_LIBRARY opencv_${module})
  list(APPEND OpenCvModules_LIBRARIES OpenCvModules_${module}_LIBRARY)
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCvModules REQUIRED_VARS OpenCvModules_INCLUDE_DIR ${OpenCvModules_LIBRARIES})
if(OpenCvModules_FOUND)
  foreach(module core imgproc imgcodecs calib3d)
    if(NOT TARGET opencv::${module})
      add_library(opencv::${module} UNKNOWN IMPORTED)
      set_target_properties(opencv::${module} PROPERTIES
        IMPORTED_LOCATION ${OpenCvModules_${module}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenCvModules_INCLUDE_DIR})
    endif()
  endforeach()
endif()
