! The model of umat.cpp in Fortran: undrained clay, elastic and perfectly plastic after von Mises.
! PROPS: Young's modulus [Pa], Poisson's ratio, shear strength [Pa]. STATEV(1): equivalent plastic strain.
!
!   gfortran -O2 -shared -fPIC -o my_soil.so umat.f90
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
                temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, &
                celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  integer, parameter :: dp = kind(1.0d0)
  character(len=80) :: cmname
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc, i
  real(dp) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), drplde(ntens)
  real(dp) :: drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1), props(nprops)
  real(dp) :: coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  real(dp) :: shear, lame, strength, mean, size

  shear = props(1) / (2 * (1 + props(2)))
  lame = props(1) * props(2) / ((1 + props(2)) * (1 - 2 * props(2)))
  strength = props(3)
  ddsdde = 0
  ddsdde(1:3, 1:3) = lame
  do i = 1, 3
    ddsdde(i, i) = lame + 2 * shear
    ddsdde(i + 3, i + 3) = shear
  end do
  stress = stress + matmul(ddsdde, dstran)
  mean = sum(stress(1:3)) / 3
  size = sqrt(0.5_dp * sum((stress(1:3) - mean)**2) + sum(stress(4:6)**2))
  if (size <= strength) return
  stress(1:3) = mean + (stress(1:3) - mean) * strength / size
  stress(4:6) = stress(4:6) * strength / size
  statev(1) = statev(1) + (size - strength) / (shear * sqrt(3.0_dp))
end subroutine umat
