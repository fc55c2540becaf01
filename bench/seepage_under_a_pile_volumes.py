# seepage under a pile: layer 2 x 0.6, heads 0.9/0.7, k=1e-4; pile of thickness t centred at 1, tip at 0.3
import numpy as np, scipy.sparse as sp, scipy.sparse.linalg as sl, sys
def q(n, t, W=2.0, H=0.6, tip=0.3, dh=0.2, k=1e-4):
    # antisymmetric about x=1: half, h=0.1 at bed, 0 on x=W/2 below the tip
    d=H/n; L=W/2-t/2
    # graded x? uniform: L must be multiple of d
    nx=int(round(L/d)); dx=L/nx; 
    A=sp.lil_matrix((nx*n,nx*n)); b=np.zeros(nx*n)
    idx=lambda i,j:i*n+j   # i from the pile (0) outwards
    rows=[];cols=[];vals=[];diag=np.zeros(nx*n)
    def link(a,c,w):
        rows.extend((a,c));cols.extend((c,a));vals.extend((-w,-w));diag[a]+=w;diag[c]+=w
    for i in range(nx):
        for j in range(n):
            if i+1<nx: link(idx(i,j),idx(i+1,j),d/dx)
            if j+1<n: link(idx(i,j),idx(i,j+1),dx/d)
            else: diag[idx(i,j)]+=2*dx/d; b[idx(i,j)]+=2*dx/d*dh/2
    # under the tip: strip of t/2 with h=0 at the middle: explicit cells
    m=int(round(t/2/d)) if t>0 else 0
    jt=int(round(tip/d)); base=nx*n
    if m==0:
        for j in range(jt): diag[idx(0,j)]+=2*d/dx
        N=base
    else:
        e=t/2/m; N=base+m*jt
        diag=np.concatenate([diag,np.zeros(m*jt)]); b=np.concatenate([b,np.zeros(m*jt)])
        id2=lambda i,j:base+i*jt+j
        for i in range(m):
            for j in range(jt):
                if i==0: link(idx(0,j),id2(0,j),d/(0.5*(dx+e)))
                if i+1<m: link(id2(i,j),id2(i+1,j),d/e)
                else: diag[id2(i,j)]+=2*d/e
                if j+1<jt: link(id2(i,j),id2(i,j+1),e/d)
    M=sp.coo_matrix((vals+list(diag),(rows+list(range(N)),cols+list(range(N)))),shape=(N,N)).tocsc()
    h=sl.spsolve(M,b)
    f=sum(2*dx/d*(dh/2-h[idx(i,n-1)]) for i in range(nx))
    return k*f
for t in (0.08,0.04,0.02,0.0):
    v=[q(n,t) for n in (60,120,240)]
    # extrapolate with observed order
    r=(v[1]-v[0])/(v[2]-v[1]); 
    print(t,v,'ratio',r,'limit',v[2]+(v[2]-v[1])/(r-1))
