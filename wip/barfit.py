import sys; sys.path.insert(0,'/tmp/fe21')
from groups import *
F=float(sys.argv[1]) if len(sys.argv)>1 else 1.25
E=[];D=[];M=[];J=[];L=[]
for d in data:
    ref=q(d,d['rows'][3],F*np.ones(6))
    for lev in range(3):
        r=d['rows'][lev]; base=q(d,r,np.zeros(6)); c=q(d,r,F*np.ones(6))
        rel=np.abs(c-base)/np.abs(c)
        for j in range(6): E.append(abs(ref[j]/c[j]-1)); D.append(rel[j]); M.append(rel[0]); J.append(j); L.append((lev,d['filleted']))
E,D,M,J,L=map(np.array,(E,D,M,J,L))
print(len(data),'F',F,'e_n err %: lev0 95%',np.round(100*np.quantile(E[(J==0)&(L[:,0]==0)],.95),3),'lev1',np.round(100*np.quantile(E[(J==0)&(L[:,0]==1)],.95),3),'lev2',np.round(100*np.quantile(E[(J==0)&(L[:,0]==2)],.95),3))
for a in (0.15,0.2,.25,.3,.35):
    for b in (0,.03,.05,.08):
        bar=a*D+b*M+2e-4
        cov=E<bar; ten=bar<10*E
        print(a,b,'cover all',round(cov.mean(),3),'by q',[round(cov[J==j].mean(),2) for j in range(6)],'ten',round(ten.mean(),2),[round(ten[J==j].mean(),2) for j in range(6)])
