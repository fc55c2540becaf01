# A plain twin of the rule of sight (docs/theory_fluid.md): ways traced one by one, Laplacian of pairs on a lattice at rest.
import numpy as np, scipy.sparse as sp, scipy.sparse.linalg as sl, sys
def run(t,dx,k=1e-4,H=.6,W=2.,tip=.3):
    a_,b_=1-t/2,1+t/2
    top=H+6*dx
    segs=[((0,0),(W,0)),((W,0),(W,top)),((0,top),(0,0))]
    if t>0: segs+=[((b_,top),(b_,tip)),((b_,tip),(a_,tip)),((a_,tip),(a_,top))]
    else: segs+=[((1,top),(1,tip))]
    segs=[(np.array(p,float),np.array(q,float)) for p,q in segs]
    nx,ny=round(W/dx),round(H/dx)
    I,J=np.meshgrid(np.arange(nx),np.arange(ny),indexing='ij')
    x=np.stack([(I.ravel()+.5)*dx,(J.ravel()+.5)*dx],1)
    solid=(x[:,0]>a_)&(x[:,0]<b_)&(x[:,1]>tip)
    idx=-np.ones(nx*ny,int); real=np.where(~solid)[0]; idx[real]=np.arange(len(real)); x=x[real]; n=len(x)
    h=1.3*dx; R=2*h
    # F=-W'/r wendland c2 2D: W=a(1-q/2)^4(2q+1), a=7/(4 pi h^2); -W'/r = 5a/h^2 (1-q/2)^3
    al=7/(4*np.pi*h*h); F=lambda r:5*al/h**2*(1-r/(2*h))**3
    m=int(R/dx); offs=[(i,j) for i in range(-m,m+1) for j in range(-m,m+1) if (i or j) and np.hypot(i,j)*dx<R]
    V=dx*dx; mom=sum(V*F(np.hypot(i,j)*dx)*(np.hypot(i,j)*dx)**2 for i,j in offs)/2; amp=1/mom
    rows=[];cols=[];vals=[];diag=np.zeros(n);rhs=np.zeros(n); face=np.zeros(n)
    fill=np.zeros(n)
    for i,j in offs:
        r=np.hypot(i,j)*dx; w=2*V*F(r)*amp  # kappa applied at the end
        pos=x.copy(); d=np.tile(np.array([i,j],float)*dx,(n,1)); last=-np.ones(n,int)
        for bounce in range(4):
            best=np.full(n,2.);bi=-np.ones(n,int)
            for s,(p,q) in enumerate(segs):
                e=q-p; nrm=np.array([-e[1],e[0]])/np.hypot(*e); L=np.hypot(*e); tau=e/L
                f=(pos-p)@nrm; g=(pos+d-p)@nrm
                two=(t==0 and s==3)
                cr=((f>1e-12)&(g<-1e-12))|(two&(f<-1e-12)&(g>1e-12))|((f>=0)&(f<=1e-12)&(g<-1e-12)&(last!=s))
                cr&=(last!=s)
                with np.errstate(all='ignore'): tt=np.abs(f)/(np.abs(f)+np.abs(g))
                al_=((pos+tt[:,None]*d)-p)@tau
                sl_=-SL if (s>=3) else 1e-9; ok=cr&(al_>=-1e-9)&(al_<=L+sl_)&(tt<best)
                best[ok]=tt[ok]; bi[ok]=s
            hit=bi>=0
            if not hit.any(): break
            pos[hit]+=best[hit,None]*d[hit]; d[hit]*=(1-best[hit])[:,None]
            for s,(p,q) in enumerate(segs):
                mm=bi==s
                e=(q-p)/np.hypot(*(q-p)); d[mm]=2*(d[mm]@e)[:,None]*e-d[mm]
            last=np.where(hit,bi,last)
        y=pos+d
        buf=y[:,1]>H
        fi=np.floor(y[:,0]/dx).astype(int); fj=np.floor(y[:,1]/dx).astype(int)
        # buffers
        refl=1+(y[:,1]-H)/(H-x[:,1])
        hb=np.where(x[:,0]<1,.9,.7)
        diag[buf]+=w*refl[buf]; rhs[buf]+=w*refl[buf]*hb[buf]; face[buf]+=w*refl[buf]
        ins=~buf&(fi>=0)&(fi<nx)&(fj>=0)
        tgt=-np.ones(n,int); tgt[ins]=idx[fi[ins]*ny+fj[ins]]
        ok=tgt>=0; fill[ok|buf]+=V*al*(1-r/(2*h))**4*(2*r/h+1)
        s_=np.where(ok)[0]
        rows+=list(s_);cols+=list(tgt[ok]);vals+=[-w]*len(s_);diag[s_]+=w
    A=sp.coo_matrix((vals+list(diag),(rows+list(range(n)),cols+list(range(n)))),shape=(n,n)).tocsc()
    asym=abs(A-A.T).max()
    hh=sl.spsolve(A,rhs)
    left=x[:,0]<1
    q=k*V*(face*(np.where(left,.9,.7)-hh))[left].sum()/1
    q/=1
    f0=fill.max(); 
    print('t',t,'dx',dx,'q',q,'asym',asym/A.max(),'fill',fill.min()/f0,'n',n,flush=True)
    return q
ref={.04:9.0619e-6,.02:9.4238e-6,0.:9.9033e-6}
SL=1e-9
for t,dx in ((0.,.04),(0.,.02),(0.,.01)):
    q=run(t,dx); print('   error %.2f %%'%(100*(q/ref[t]-1)),flush=True)
